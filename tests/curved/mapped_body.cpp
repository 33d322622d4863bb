// SPDX-License-Identifier: Apache-2.0
#include "tests/curved/mapped_body.hpp"

#include "core/mat3.hpp"
#include "mpm_fem/fem/shape_functions.hpp"
#include "mpm_fem/fem/voxel_tets.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace elastogen::test {
namespace {

using fem::ElementMesh;
using Place = std::array<int, 3>;

/// The box as a lattice of cells.
struct BoxLattice {
  Place count;   // cells along each axis
  Place middle;  // cells of the axis at negative coordinates
  Place half;    // cells along [0, 1]

  int32_t node(const Place& at) const {
    return int32_t(at[0] + (count[0] + 1) * (at[1] + (count[1] + 1) * at[2]));
  }
  Vec3 point(const Place& at) const {
    Vec3 p;
    for (size_t d = 0; d < 3; ++d) p[d] = double(at[d] - middle[d]) / half[d];
    return p;
  }
  template <class Body>
  static void for_each_place(const Place& end, const Body& body) {
    Place at;
    for (at[2] = 0; at[2] < end[2]; ++at[2])
      for (at[1] = 0; at[1] < end[1]; ++at[1])
        for (at[0] = 0; at[0] < end[0]; ++at[0]) body(at);
  }
};

BoxLattice lattice_of(const MappedBody& body, int n, bool octant) {
  BoxLattice lattice;
  for (size_t d = 0; d < 3; ++d) {
    lattice.half[d] = n * body.cells[d];
    lattice.middle[d] = body.mirrored[d] && !octant ? lattice.half[d] : 0;
    lattice.count[d] = lattice.half[d] + lattice.middle[d];
  }
  return lattice;
}

Place corner_of(const Place& cell, int c) {
  return {cell[0] + (c & 1), cell[1] + (c >> 1 & 1), cell[2] + (c >> 2)};
}

/// Nodes at rest of the lattice, mapped if there is a map.
Array<double> lattice_nodes(const BoxLattice& lattice,
                            const std::function<Vec3(const Vec3&)>& map) {
  const Place end = {lattice.count[0] + 1, lattice.count[1] + 1, lattice.count[2] + 1};
  Array<double> X(int64_t(end[0]) * end[1] * end[2], 3);
  BoxLattice::for_each_place(end, [&](const Place& at) {
    const Vec3 p = lattice.point(at), x = map ? map(p) : p;
    std::copy(x.begin(), x.end(), X.row(lattice.node(at)));
  });
  return X;
}

}  // namespace

fem::ElementMesh mapped_tets(const MappedBody& body, int n, bool octant) {
  const BoxLattice lattice = lattice_of(body, n, octant);
  ElementMesh linear;
  linear.element = fem::Element::kTet4;
  linear.rest = lattice_nodes(lattice, {});
  const int64_t cells = int64_t(lattice.count[0]) * lattice.count[1] * lattice.count[2];
  // mirror the cells below the middle planes, so that the tetrahedra are symmetric about them
  Array<int32_t> hexahedra(cells, 8);
  std::vector<uint8_t> odd;  // mirrored an odd number of times
  BoxLattice::for_each_place(lattice.count, [&](const Place& cell) {
    int flip = 0;
    for (size_t d = 0; d < 3; ++d) flip |= (cell[d] < lattice.middle[d]) << d;
    for (int c = 0; c < 8; ++c)
      hexahedra(int64_t(odd.size()), c) = lattice.node(corner_of(cell, c ^ flip));
    odd.push_back(std::popcount(unsigned(flip)) & 1);
  });
  linear.elements = fem::kuhn_tets(hexahedra);
  // a mirrored tetrahedron is inside out: swap two of its corners
  for (int64_t e = 0; e < linear.elements.rows(); ++e)
    if (odd[size_t(e / 6)]) std::swap(linear.elements(e, 2), linear.elements(e, 3));
  linear.material = Array<int32_t>(linear.elements.rows());

  ElementMesh mesh = fem::quadratic(linear);
  // map all nodes, so that edges are curved
  for (int64_t node = 0; node < mesh.rest.rows(); ++node) {
    double* X = mesh.rest.row(node);
    const Vec3 x = body.map({X[0], X[1], X[2]});
    std::copy(x.begin(), x.end(), X);
  }
  return mesh;
}

Surface mapped_surface(const MappedBody& body, int n) {
  const BoxLattice lattice = lattice_of(body, n, false);
  // corners of each face of a cell, counterclockwise from outside
  constexpr int kFace[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                               {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  const Array<double> nodes = lattice_nodes(lattice, body.map);
  std::vector<int32_t> corners, number(size_t(nodes.rows()), -1);
  std::vector<double> vertices;
  const auto vertex = [&](int32_t node) {
    if (number[size_t(node)] < 0) {
      number[size_t(node)] = int32_t(vertices.size() / 3);
      vertices.insert(vertices.end(), nodes.row(node), nodes.row(node) + 3);
    }
    return number[size_t(node)];
  };
  BoxLattice::for_each_place(lattice.count, [&](const Place& cell) {
    for (int face = 0; face < 6; ++face) {
      const auto axis = size_t(face / 2);
      if (cell[axis] != (face % 2 ? lattice.count[axis] - 1 : 0)) continue;
      // along the diagonal that points away from the middle, as the tetrahedra
      const size_t u = (axis + 1) % 3, w = (axis + 2) % 3;
      const int turn = (cell[u] < lattice.middle[u]) != (cell[w] < lattice.middle[w]);
      int32_t v[4];
      for (int k = 0; k < 4; ++k)
        v[k] = vertex(lattice.node(corner_of(cell, kFace[face][(k + turn) % 4])));
      corners.insert(corners.end(), {v[0], v[1], v[2], v[0], v[2], v[3]});
    }
  });
  Surface surface;
  surface.vertices = Array<double>(int64_t(vertices.size()) / 3, 3);
  std::copy(vertices.begin(), vertices.end(), surface.vertices.data());
  surface.triangles = Array<int32_t>(int64_t(corners.size()) / 3, 3);
  std::copy(corners.begin(), corners.end(), surface.triangles.data());
  surface.material = Array<int32_t>(surface.triangles.rows());
  surface.material.fill(-1);
  for (int64_t v = 0; v < surface.vertices.rows(); ++v) {
    const double* x = surface.vertices.row(v);
    surface.box.add({x[0], x[1], x[2]});
  }
  return surface;
}

double worst_shape(const fem::ElementMesh& tets) {
  constexpr int kEdge[6][2] = {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}};
  constexpr double kCorner[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  double worst = 1;
  for (int64_t e = 0; e < tets.elements.rows(); ++e) {
    double X[30], square = 0;
    fem::element_nodes(tets, e, X);
    for (const auto& [a, b] : kEdge)
      for (int d = 0; d < 3; ++d) square += std::pow(X[3 * a + d] - X[3 * b + d], 2) / 6;
    for (int node = 0; node < 10; ++node) {
      Vec3 xi;
      for (size_t d = 0; d < 3; ++d)
        xi[d] = node < 4 ? kCorner[node][d]
                         : 0.5 * (kCorner[kEdge[node - 4][0]][d] + kCorner[kEdge[node - 4][1]][d]);
      double dN[30];
      Mat3<double> J;
      fem::shape_gradients(fem::Element::kTet10, xi, dN);
      fem::jacobian(fem::Element::kTet10, X, dN, J.m);
      worst = std::min(worst, std::sqrt(2.0) * determinant(J) / std::pow(square, 1.5));
    }
  }
  return worst;
}

void to_ball(double* p, int dimensions) {
  // of the shares of the disc's and the ball's radius that the inner square and cube have, those
  // that keep the cells about equally large
  const double inner = dimensions == 2 ? 0.75 : 0.65;
  double size = 0, square = 0;
  for (int d = 0; d < dimensions; ++d) {
    size = std::max(size, std::abs(p[d]));
    square += p[d] * p[d];
  }
  if (size == 0) return;
  const double scale = inner * (1 - size * size) + size * size * size / std::sqrt(square);
  for (int d = 0; d < dimensions; ++d) p[d] *= scale;
}

}  // namespace elastogen::test
