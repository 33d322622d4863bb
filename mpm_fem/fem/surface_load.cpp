// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/fem/surface_load.hpp"

#include "core/error.hpp"
#include "core/vec3.hpp"
#include "mpm_fem/fem/tet_surface.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace elastogen::fem {
namespace {

/// Corners of the faces of a hexahedron; side 2 d + s has the corners whose bit d equals s.
constexpr int kQuads[6][4] = {{0, 2, 4, 6}, {1, 3, 5, 7}, {0, 1, 4, 5},
                              {2, 3, 6, 7}, {0, 1, 2, 3}, {4, 5, 6, 7}};

struct LoadedFace {
  std::array<int32_t, 4> key;  ///< its nodes in ascending order; a triangle has -1 before them
  int64_t element;
  int side;
};

bool is_hexahedron(const ElementMesh& mesh) {
  return nodes_of(mesh.element) == 8;
}

/// Faces with one element whose corners are all selected, in the order of their nodes.
std::vector<LoadedFace> selected_faces(const ElementMesh& mesh, In<uint8_t> selected) {
  const bool hexahedron = is_hexahedron(mesh);
  const int sides = hexahedron ? 6 : 4, corners = hexahedron ? 4 : 3;
  std::vector<LoadedFace> faces;
  // all faces with selected corners, sorted by their nodes
  for (int64_t e = 0; e < mesh.elements.rows(); ++e)
    for (int side = 0; side < sides; ++side) {
      LoadedFace face{{-1, -1, -1, -1}, e, side};
      bool inside = true;
      for (int c = 0; c < corners; ++c) {
        face.key[size_t(c)] = mesh.elements(e, hexahedron ? kQuads[side][c] : kTetFaces[side][c]);
        inside &= selected(face.key[size_t(c)]) != 0;
      }
      std::sort(face.key.begin(), face.key.end());
      if (inside) faces.push_back(face);
    }
  std::stable_sort(faces.begin(), faces.end(),
                   [](const LoadedFace& a, const LoadedFace& b) { return a.key < b.key; });
  // those without a second element
  std::vector<LoadedFace> outer;
  for (size_t k = 0; k < faces.size(); ++k) {
    const bool before = k > 0 && faces[k - 1].key == faces[k].key;
    const bool after = k + 1 < faces.size() && faces[k + 1].key == faces[k].key;
    if (!before && !after) outer.push_back(faces[k]);
  }
  return outer;
}

Vec3 edge(const ElementMesh& mesh, int32_t from, int32_t to) {
  Vec3 x;
  for (int d = 0; d < 3; ++d) x[size_t(d)] = mesh.rest(to, d) - mesh.rest(from, d);
  return x;
}

/// Half of (b - a) x (d - c) of four nodes [m^2].
Vec3 half_cross(const ElementMesh& mesh, int32_t a, int32_t b, int32_t c, int32_t d) {
  Vec3 area = cross(edge(mesh, a, b), edge(mesh, c, d));
  for (double& x : area) x /= 2;
  return area;
}

/// Area of a quadrilateral along its outward normal, times the fill [m^2]; its diagonals cross.
Vec3 quad_area(const ElementMesh& mesh, const LoadedFace& face) {
  const int32_t* node = mesh.elements.row(face.element);
  const int* corner = kQuads[face.side];
  Vec3 area = half_cross(mesh, node[corner[0]], node[corner[3]], node[corner[1]], node[corner[2]]);
  const bool turned = (face.side % 2 == 0) != (face.side / 2 == 1);  // diagonals of y run backwards
  const double factor = is_voxel_mesh(mesh) ? mesh.fill(face.element) : 1;
  for (double& x : area) x *= turned ? -factor : factor;
  return area;
}

/// Share of corner c in the area of a quadrilateral.
double quad_share(const ElementMesh& mesh, const LoadedFace& face, int c) {
  if (mesh.element != Element::kVoxel) return 0.25;
  const int corner = kQuads[face.side][c], mirrored = corner ^ (1 << face.side / 2);
  return mesh.shape_mean(face.element, corner) + mesh.shape_mean(face.element, mirrored);
}

/// Nodes of the face of a tetrahedron: corners counterclockwise from outside, then middles.
std::array<int32_t, 6> triangle_nodes(const ElementMesh& mesh, const LoadedFace& face) {
  const int32_t* node = mesh.elements.row(face.element);
  std::array<int32_t, 6> nodes = {};
  for (size_t c = 0; c < 3; ++c) {
    nodes[c] = node[kTetFaces[face.side][c]];
    if (nodes_of(mesh.element) == 10) nodes[3 + c] = node[kTetFaceMiddles[face.side][c]];
  }
  return nodes;
}

/// Adds the shares of the nodes in the area of a face [m^2].
void add_area(const ElementMesh& mesh, const LoadedFace& face, Array<double>& area) {
  if (is_hexahedron(mesh)) {
    const double size = norm(quad_area(mesh, face));
    for (int c = 0; c < 4; ++c)
      area(mesh.elements(face.element, kQuads[face.side][c])) += quad_share(mesh, face, c) * size;
    return;
  }
  const std::array<int32_t, 6> node = triangle_nodes(mesh, face);
  const double size = norm(half_cross(mesh, node[0], node[1], node[0], node[2]));
  const size_t first = nodes_of(mesh.element) == 10 ? 3 : 0;
  for (size_t c = first; c < first + 3; ++c) area(node[c]) += size / 3;
}

void add_row(int32_t node, double factor, const Vec3& x, Array<double>& load) {
  for (int d = 0; d < 3; ++d) load(node, d) += factor * x[size_t(d)];
}

/// Adds factor int N_a n dA of a quadratic triangle, n dA = dX/dL1 x dX/dL2 dL1 dL2: degree 4 in
/// the barycentric coordinates L, by six points (Dunavant 1985).
void add_curved(const ElementMesh& mesh, const std::array<int32_t, 6>& node, double factor,
                Array<double>& load) {
  constexpr double kOrbits[2][2] = {{0.091576213509770743, 0.10995174365532187},
                                    {0.44594849091596489, 0.22338158967801147}};
  for (const auto& [b, weight] : kOrbits)
    for (size_t corner = 0; corner < 3; ++corner) {
      std::array<double, 3> L = {b, b, b};
      L[corner] = 1 - 2 * b;
      // shape functions, and tangents of the curved face
      Vec3 along[2] = {};  // dX/dL1, dX/dL2
      double N[6];
      for (size_t c = 0; c < 3; ++c) {
        const size_t next = (c + 1) % 3;
        N[c] = L[c] * (2 * L[c] - 1);
        N[3 + c] = 4 * L[c] * L[next];
        for (size_t k = 1; k < 3; ++k) {
          const auto slope = [&](size_t of) { return (of == k) - (of == 0 ? 1.0 : 0.0); };
          const double middle = 4 * (slope(c) * L[next] + L[c] * slope(next));
          for (size_t d = 0; d < 3; ++d)
            along[k - 1][d] += (4 * L[c] - 1) * slope(c) * mesh.rest(node[c], int64_t(d)) +
                               middle * mesh.rest(node[3 + c], int64_t(d));
        }
      }
      // the point's n dA, spread over the nodes
      const Vec3 normal = cross(along[0], along[1]);
      for (size_t a = 0; a < 6; ++a) add_row(node[a], factor * weight / 2 * N[a], normal, load);
    }
}

/// Adds factor int N_a n dA of a face.
void add_normal(const ElementMesh& mesh, const LoadedFace& face, double factor,
                Array<double>& load) {
  if (is_hexahedron(mesh)) {
    const Vec3 area = quad_area(mesh, face);
    for (int c = 0; c < 4; ++c)
      add_row(mesh.elements(face.element, kQuads[face.side][c]), factor * quad_share(mesh, face, c),
              area, load);
    return;
  }
  const std::array<int32_t, 6> node = triangle_nodes(mesh, face);
  if (nodes_of(mesh.element) == 10) return add_curved(mesh, node, factor, load);
  const Vec3 area = half_cross(mesh, node[0], node[1], node[0], node[2]);
  for (size_t c = 0; c < 3; ++c) add_row(node[c], factor / 3, area, load);
}

void check_selected(const ElementMesh& mesh, In<uint8_t> selected) {
  const int64_t nodes = mesh.rest.rows();
  ELASTOGEN_CHECK(!is_plane(mesh.element), "a plane mesh has no faces that bear a load");
  ELASTOGEN_CHECK(selected.rows == nodes && selected.cols == 1, "selected must be (", nodes,
                  ", 1), got (", selected.rows, ", ", selected.cols, ")");
}

}  // namespace

Array<double> surface_load(const ElementMesh& mesh, In<uint8_t> selected, const Vec3& force) {
  check_selected(mesh, selected);
  const int64_t nodes = mesh.rest.rows();
  Array<double> area(nodes);
  for (const LoadedFace& face : selected_faces(mesh, selected)) add_area(mesh, face, area);
  double total = 0;
  for (int64_t n = 0; n < nodes; ++n) total += area(n);
  if (total == 0) return {};
  Array<double> load(nodes, 3);
  for (int64_t n = 0; n < nodes; ++n)
    for (int d = 0; d < 3; ++d) load(n, d) = force[size_t(d)] * (area(n) / total);
  return load;
}

Array<double> pressure_load(const ElementMesh& mesh, In<uint8_t> selected, double pressure) {
  check_selected(mesh, selected);
  ELASTOGEN_CHECK(std::isfinite(pressure), "the pressure must be finite, got ", pressure);
  const std::vector<LoadedFace> faces = selected_faces(mesh, selected);
  if (faces.empty()) return {};
  Array<double> load(mesh.rest.rows(), 3);
  for (const LoadedFace& face : faces) add_normal(mesh, face, -pressure, load);
  return load;
}

}  // namespace elastogen::fem
