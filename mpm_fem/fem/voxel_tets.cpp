// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/fem/voxel_tets.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"

#include <algorithm>
#include <limits>

namespace elastogen::fem {
namespace {

constexpr int kFive[5][4] = {{1, 2, 4, 7}, {0, 1, 2, 4}, {3, 2, 1, 7}, {5, 4, 7, 1}, {6, 7, 4, 2}};

/// From corner 0 along the axes in each of their orders to corner 7; odd orders have two corners
/// swapped, so that the volume is positive.
constexpr int kSix[6][4] = {{0, 1, 3, 7}, {0, 2, 6, 7}, {0, 4, 5, 7},
                            {0, 3, 2, 7}, {0, 6, 4, 7}, {0, 5, 1, 7}};

/// Corners of the edges whose middles are the nodes 4 ... 9 of a quadratic tetrahedron.
constexpr int kEdge[6][2] = {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}};

void check_tet4(const ElementMesh& mesh) {
  ELASTOGEN_CHECK(mesh.element == Element::kTet4 && mesh.elements.cols() == 4 &&
                      mesh.material.rows() == mesh.elements.rows() && mesh.rest.cols() == 3,
                  "linear tetrahedra are expected, got elements ",
                  Span<const int32_t>(mesh.elements));
  for (int64_t k = 0; k < mesh.elements.size(); ++k) {
    const int32_t node = mesh.elements.data()[k];
    ELASTOGEN_CHECK(node >= 0 && node < mesh.rest.rows(), "corner ", k % 4, " of element ", k / 4,
                    " is node ", node, ", there are ", mesh.rest.rows());
  }
}

/// The edges of a mesh, each once, sorted.
class Edges {
 public:
  explicit Edges(const Array<int32_t>& tets) : keys_(size_t(6 * tets.rows())) {
    for_each(tets.rows(), [&](int64_t e) {
      for (int k = 0; k < 6; ++k)
        keys_[size_t(6 * e + k)] = key(tets(e, kEdge[k][0]), tets(e, kEdge[k][1]));
    });
    std::sort(keys_.begin(), keys_.end());
    keys_.erase(std::unique(keys_.begin(), keys_.end()), keys_.end());
  }

  int64_t count() const { return int64_t(keys_.size()); }
  int64_t find(int32_t a, int32_t b) const {
    return std::lower_bound(keys_.begin(), keys_.end(), key(a, b)) - keys_.begin();
  }
  int32_t first(int64_t edge) const { return int32_t(keys_[size_t(edge)] >> 32); }
  int32_t second(int64_t edge) const { return int32_t(keys_[size_t(edge)] & 0xffffffff); }

 private:
  static uint64_t key(int32_t a, int32_t b) {
    return uint64_t(std::min(a, b)) << 32 | uint64_t(std::max(a, b));
  }

  std::vector<uint64_t> keys_;
};

double squared_distance(const Array<double>& x, int32_t a, int32_t b) {
  double sum = 0;
  for (int d = 0; d < 3; ++d) sum += (x(a, d) - x(b, d)) * (x(a, d) - x(b, d));
  return sum;
}

/// The octahedron of the nodes n[4] ... n[9] cut along its shortest diagonal.
void cut_octahedron(const Array<double>& rest, const int32_t* n, int32_t* tets) {
  // the ends of a diagonal and the four nodes around it, counterclockwise from the second end
  constexpr int kCut[3][6] = {{6, 8, 4, 5, 9, 7}, {5, 7, 4, 8, 9, 6}, {4, 9, 5, 6, 7, 8}};
  double length[3];
  for (int k = 0; k < 3; ++k) length[k] = squared_distance(rest, n[kCut[k][0]], n[kCut[k][1]]);
  // the first of diagonals that are equally long up to rounding, so that like shapes are cut alike
  const double limit = *std::min_element(length, length + 3) * (1 + 1e-9);
  const int* cut =
      kCut[std::find_if(length, length + 3, [&](double l) { return l <= limit; }) - length];
  for (int k = 0; k < 4; ++k) {
    const int32_t tet[4] = {n[cut[0]], n[cut[1]], n[cut[2 + k]], n[cut[2 + (k + 1) % 4]]};
    std::copy(tet, tet + 4, tets + 4 * k);
  }
}

}  // namespace

Array<int32_t> kuhn_tets(In<int32_t> hexahedra) {
  ELASTOGEN_CHECK(hexahedra.cols == 8, "hexahedra must be (hexahedra, 8), got ", hexahedra);
  Array<int32_t> tets(6 * hexahedra.rows, 4);
  for_each(hexahedra.rows, [&](int64_t h) {
    for (int t = 0; t < 6; ++t)
      for (int k = 0; k < 4; ++k) tets(6 * h + t, k) = hexahedra(h, kSix[t][k]);
  });
  return tets;
}

ElementMesh voxel_tets(const Scene& scene, VoxelSplit split) {
  const VoxelGrid& grid = scene.grid;
  ELASTOGEN_CHECK(grid.voxel_count() > 0 && scene.material.rows() == grid.voxel_count(),
                  "a material for each of the voxels is expected, got ",
                  Span<const int32_t>(scene.material), " for ", grid.voxel_count(), " voxels");
  const int per_voxel = split == VoxelSplit::kFive ? 5 : 6;
  ElementMesh mesh;
  mesh.element = Element::kTet4;
  mesh.rest = grid.rest;
  mesh.material = Array<int32_t>(per_voxel * grid.voxel_count());
  for (int64_t e = 0; e < mesh.material.rows(); ++e)
    mesh.material(e) = scene.material(e / per_voxel);
  mesh.fill = Array<double>(per_voxel * grid.voxel_count());
  for (int64_t e = 0; e < mesh.fill.rows(); ++e) mesh.fill(e) = grid.fill(e / per_voxel);
  if (split == VoxelSplit::kSix) {
    mesh.elements = kuhn_tets(grid.corners);
    return mesh;
  }

  // voxels of odd coordinates: the mirror image, corner c ^ 1, with two corners swapped again
  mesh.elements = Array<int32_t>(5 * grid.voxel_count(), 4);
  for_each(grid.voxel_count(), [&](int64_t v) {
    const int32_t* at = grid.voxel_coord.row(v);
    const int odd = (at[0] ^ at[1] ^ at[2]) & 1;
    for (int t = 0; t < 5; ++t)
      for (int k = 0; k < 4; ++k)
        mesh.elements(5 * v + t, odd && k > 1 ? 5 - k : k) = grid.corners(v, kFive[t][k] ^ odd);
  });
  return mesh;
}

ElementMesh quadratic(const ElementMesh& mesh) {
  check_tet4(mesh);
  const Edges edges(mesh.elements);
  const int64_t corners = mesh.rest.rows(), nodes = corners + edges.count();
  ELASTOGEN_CHECK(nodes <= std::numeric_limits<int32_t>::max(), "the mesh would have ", nodes,
                  " nodes, more than 32 bits count");
  ElementMesh result;
  result.element = Element::kTet10;
  result.material = mesh.material;
  result.fill = mesh.fill;
  // nodes: the corners, then the middles of edges
  result.rest = Array<double>(nodes, 3);
  std::copy(mesh.rest.data(), mesh.rest.data() + mesh.rest.size(), result.rest.data());
  for_each(edges.count(), [&](int64_t k) {
    for (int d = 0; d < 3; ++d)
      result.rest(corners + k, d) =
          0.5 * (mesh.rest(edges.first(k), d) + mesh.rest(edges.second(k), d));
  });
  // elements: four corners, then six middles
  result.elements = Array<int32_t>(mesh.elements.rows(), 10);
  for_each(mesh.elements.rows(), [&](int64_t e) {
    const int32_t* corner = mesh.elements.row(e);
    std::copy(corner, corner + 4, result.elements.row(e));
    for (int k = 0; k < 6; ++k)
      result.elements(e, 4 + k) =
          int32_t(corners + edges.find(corner[kEdge[k][0]], corner[kEdge[k][1]]));
  });
  return result;
}

ElementMesh refined(const ElementMesh& mesh) {
  const ElementMesh middles = quadratic(mesh);
  constexpr int kCorner[4][4] = {{0, 4, 6, 7}, {4, 1, 5, 8}, {6, 5, 2, 9}, {7, 8, 9, 3}};
  ElementMesh result;
  result.element = Element::kTet4;
  result.rest = middles.rest;
  result.elements = Array<int32_t>(8 * mesh.elements.rows(), 4);
  result.material = Array<int32_t>(8 * mesh.elements.rows());
  if (!mesh.fill.empty()) result.fill = Array<double>(8 * mesh.elements.rows());
  for_each(mesh.elements.rows(), [&](int64_t e) {
    const int32_t* n = middles.elements.row(e);
    for (int t = 0; t < 4; ++t)
      for (int k = 0; k < 4; ++k) result.elements(8 * e + t, k) = n[kCorner[t][k]];
    cut_octahedron(result.rest, n, result.elements.row(8 * e + 4));
    for (int t = 0; t < 8; ++t) {
      result.material(8 * e + t) = mesh.material(e);
      if (!mesh.fill.empty()) result.fill(8 * e + t) = mesh.fill(e);
    }
  });
  return result;
}

}  // namespace elastogen::fem
