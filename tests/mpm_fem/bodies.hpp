// SPDX-License-Identifier: Apache-2.0
// Small meshes of every element, states of them, and their derivatives as Eigen's vectors and
// matrices (dof 3 node + component).

#pragma once

#include "mpm_fem/fem/elastic_body.hpp"
#include "tests/support/matrices.hpp"
#include "voxelize/bricks.hpp"

#include <Eigen/SparseCore>

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

namespace elastogen::test {

using fem::ElasticBody;
using fem::Element;
using fem::ElementMesh;

inline constexpr Element kAllElements[6] = {Element::kVoxel, Element::kHex,   Element::kHexBbar,
                                            Element::kTet4,  Element::kTet10, Element::kTet10Bbar};

inline Material solid(Law law = Law::kNeoHookean, double young = 1, double poisson = 0.3,
                      double density = 1000) {
  return {.name = "test", .law = law, .young = young, .poisson = poisson, .density = density};
}

inline Vec3 rest_of(const ElementMesh& mesh, int64_t node) {
  return {mesh.rest(node, 0), mesh.rest(node, 1), mesh.rest(node, 2)};
}

/// Whether a node lies on the boundary of the cube [0, edge]^3.
inline bool on_boundary(const ElementMesh& mesh, int64_t node, double edge) {
  for (const double x : rest_of(mesh, node))
    if (std::min(x, edge - x) < 1e-9) return true;
  return false;
}

/// The table of elements from a list of nodes; every element has material 0.
inline void set_elements(ElementMesh& mesh, const std::vector<int32_t>& nodes) {
  const int per = fem::nodes_of(mesh.element);
  mesh.elements = Array<int32_t>(int64_t(nodes.size()) / per, per);
  std::copy(nodes.begin(), nodes.end(), mesh.elements.data());
  mesh.material = Array<int32_t>(mesh.elements.rows());
}

/// Turns linear tetrahedra into quadratic ones with straight edges.
inline ElementMesh quadratic(const ElementMesh& linear, Element element) {
  constexpr int kEdges[6][2] = {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}};
  std::map<std::pair<int32_t, int32_t>, int32_t> middle;
  std::vector<int32_t> nodes;
  std::vector<double> rest(linear.rest.data(), linear.rest.data() + linear.rest.size());
  for (int64_t e = 0; e < linear.elements.rows(); ++e) {
    const int32_t* corner = linear.elements.row(e);
    nodes.insert(nodes.end(), corner, corner + 4);
    for (const auto& [first, second] : kEdges) {
      const auto [a, b] = std::minmax(corner[first], corner[second]);
      const auto [place, fresh] = middle.try_emplace({a, b}, int32_t(rest.size() / 3));
      for (int d = 0; fresh && d < 3; ++d)
        rest.push_back((linear.rest(a, d) + linear.rest(b, d)) / 2);
      nodes.push_back(place->second);
    }
  }
  ElementMesh mesh;
  mesh.element = element;
  mesh.rest = Array<double>(int64_t(rest.size()) / 3, 3);
  std::copy(rest.begin(), rest.end(), mesh.rest.data());
  set_elements(mesh, nodes);
  return mesh;
}

/// Six tetrahedra of a cube: from corner 0 to corner 7 along the axes in every order.
inline void append_tetrahedra(const int32_t corner[8], std::vector<int32_t>& nodes) {
  for (int first = 0; first < 3; ++first)
    for (const int turn : {1, 2}) {
      const int a = 1 << first, b = a | 1 << (first + turn) % 3;
      const int second = turn == 1 ? a : b, third = turn == 1 ? b : a;
      nodes.insert(nodes.end(), {corner[0], corner[second], corner[third], corner[7]});
    }
}

/// The box of nx x ny x nz cubes of edge h as hexahedra that need not be cubes, or with six
/// tetrahedra a cube.
/// @param shift  inner corners are moved by up to this share of h along each axis.
inline ElementMesh block(Element element, int nx, int ny, int nz, double h, double shift = 0) {
  Random random(1);
  std::uniform_real_distribution<double> moved(-shift * h, shift * h);
  const int size[3] = {nx, ny, nz};
  ElementMesh mesh;
  mesh.element = fem::nodes_of(element) == 10 ? Element::kTet4 : element;
  mesh.rest = Array<double>(int64_t(nx + 1) * (ny + 1) * (nz + 1), 3);
  std::vector<int32_t> nodes;
  for (int32_t n = 0; n < mesh.rest.rows(); ++n) {
    const int at[3] = {n % (nx + 1), n / (nx + 1) % (ny + 1), n / (nx + 1) / (ny + 1)};
    // a node inside moves; a cube starts at each node but those of the upper faces
    bool inner = true, starts = true;
    for (int d = 0; d < 3; ++d) {
      inner &= at[d] > 0 && at[d] < size[d];
      starts &= at[d] < size[d];
    }
    for (int d = 0; d < 3; ++d) mesh.rest(n, d) = at[d] * h + (inner ? moved(random) : 0);
    if (!starts) continue;
    int32_t corner[8];
    for (int c = 0; c < 8; ++c)
      corner[c] = n + (c & 1) + (nx + 1) * ((c >> 1 & 1) + (ny + 1) * (c >> 2));
    if (fem::nodes_of(element) == 8)
      nodes.insert(nodes.end(), corner, corner + 8);
    else
      append_tetrahedra(corner, nodes);
  }
  set_elements(mesh, nodes);
  return fem::nodes_of(element) == 10 ? quadratic(mesh, element) : mesh;
}

/// A finished scene of the grid with one material and nothing pinned.
inline Scene voxel_scene(VoxelGrid grid, const Material& material,
                         Hourglass hourglass = Hourglass::kFull) {
  Scene scene;
  scene.grid = std::move(grid);
  scene.materials = {material};
  scene.material = Array<int32_t>(scene.grid.voxel_count());
  scene.pinned = Array<uint8_t>(scene.grid.node_count());
  scene.hourglass = hourglass;
  finish_scene(scene);
  return scene;
}

/// A voxel of edge 1 filled by 0.4 about a random place, with unequal weights.
inline ElementMesh one_voxel(Random& random, Hourglass hourglass) {
  std::uniform_real_distribution<double> unit(0, 1);
  VoxelGrid grid = make_box(1, 1, 1, 1);
  grid.fill.fill(0.4);
  const double place[3] = {unit(random), unit(random), unit(random)};
  for (int c = 0; c < 8; ++c) {
    grid.shape_mean(0, c) = 1;
    for (int d = 0; d < 3; ++d) grid.shape_mean(0, c) *= c >> d & 1 ? place[d] : 1 - place[d];
  }
  ElementMesh mesh = fem::voxel_mesh(voxel_scene(grid, solid(), hourglass), Element::kVoxel);
  for (int k = 0; k < 4; ++k) mesh.variance(0, k) = 0.3 + 0.2 * unit(random);
  return mesh;
}

/// The first element of a mesh alone.
inline ElementMesh first_element(const ElementMesh& mesh) {
  const int nodes = fem::nodes_of(mesh.element);
  ElementMesh first;
  first.element = mesh.element;
  first.rest = Array<double>(nodes, 3);
  std::vector<int32_t> order;
  for (int a = 0; a < nodes; ++a) {
    order.push_back(a);
    for (int d = 0; d < 3; ++d) first.rest(a, d) = mesh.rest(mesh.elements(0, a), d);
  }
  set_elements(first, order);
  return first;
}

/// One element of edge about 1, turned and distorted, tet10 with curved edges; of voxels
/// one_voxel.
inline ElementMesh one_element(Element element, Random& random,
                               Hourglass hourglass = Hourglass::kFull) {
  if (element == Element::kVoxel) return one_voxel(random, hourglass);
  ElementMesh mesh = first_element(block(element, 1, 1, 1, 1));
  std::normal_distribution<double> normal(0, fem::nodes_of(element) == 10 ? 0.02 : 0.06);
  const Mat3<double> R = rotation(random);
  for (int64_t a = 0; a < mesh.rest.rows(); ++a) {
    const Vec3 X = rest_of(mesh, a);
    for (int i = 0; i < 3; ++i)
      mesh.rest(a, i) = R(i, 0) * X[0] + R(i, 1) * X[1] + R(i, 2) * X[2] + normal(random);
  }
  return mesh;
}

/// u of x = F X, plus noise [m] on every component.
inline Array<double> displaced(const ElementMesh& mesh, const Mat3<double>& F, double noise,
                               Random& random) {
  std::normal_distribution<double> normal;
  Array<double> u(mesh.rest.rows(), 3);
  for (int64_t n = 0; n < u.rows(); ++n)
    for (int i = 0; i < 3; ++i) {
      u(n, i) = noise * normal(random) - mesh.rest(n, i);
      for (int j = 0; j < 3; ++j) u(n, i) += F(i, j) * mesh.rest(n, j);
    }
  return u;
}

/// A state of one element that has a quadrature point with det F < 0.
inline Array<double> inverted(const ElasticBody& body, Random& random) {
  const ElementMesh& mesh = body.mesh();
  const bool one_point = mesh.element == Element::kVoxel || mesh.element == Element::kTet4;
  Array<double> u =
      displaced(mesh, stretched(1.3, 1, one_point ? -0.5 : 0.8, random), 0.02, random);
  // draw the first corner through the middle until a point turns over
  while (body.min_j(u) > -0.02)
    for (int d = 0; d < 3; ++d)
      for (int64_t n = 1; n < u.rows(); ++n)
        u(0, d) +=
            0.05 / double(u.rows() - 1) * (mesh.rest(n, d) + u(n, d) - mesh.rest(0, d) - u(0, d));
  return u;
}

inline Eigen::VectorXd vector_of(const Array<double>& u) {
  return Eigen::Map<const Eigen::VectorXd>(u.data(), u.size());
}

inline Array<double> array_of(const Eigen::VectorXd& u) {
  Array<double> result(u.size() / 3, 3);
  std::copy(u.data(), u.data() + u.size(), result.data());
  return result;
}

/// Elastic and hourglass energy [J].
inline double energy(const ElasticBody& body, const Array<double>& u) {
  const EnergyParts parts = body.energy(u);
  return parts.elastic + parts.hourglass;
}

inline Eigen::VectorXd gradient(const ElasticBody& body, const Array<double>& u) {
  Array<double> g(u.rows(), 3);
  body.add_gradient(u, g);
  return vector_of(g);
}

inline Eigen::MatrixXd element_hessian(const ElasticBody& body, int64_t element,
                                       const Array<double>& u, TangentKind kind) {
  const int size = 3 * fem::nodes_of(body.mesh().element);
  Eigen::MatrixXd K(size, size);
  body.element_hessian(element, u, kind, K.data());
  return K;
}

/// The Hessian of the whole body.
inline Eigen::SparseMatrix<double> hessian(const ElasticBody& body, const Array<double>& u,
                                           TangentKind kind = TangentKind::kTrue) {
  const Array<int32_t>& elements = body.mesh().elements;
  std::vector<Eigen::Triplet<double>> entries;
  for (int64_t e = 0; e < elements.rows(); ++e) {
    const Eigen::MatrixXd K = element_hessian(body, e, u, kind);
    for (int row = 0; row < K.rows(); ++row)
      for (int col = 0; col < K.cols(); ++col)
        entries.emplace_back(3 * elements(e, row / 3) + row % 3, 3 * elements(e, col / 3) + col % 3,
                             K(row, col));
  }
  Eigen::SparseMatrix<double> result(body.mesh().rest.size(), body.mesh().rest.size());
  result.setFromTriplets(entries.begin(), entries.end());
  return result;
}

}  // namespace elastogen::test
