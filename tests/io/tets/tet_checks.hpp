// SPDX-License-Identifier: Apache-2.0
// Checks of meshes of tetrahedra with the members `rest` and `elements`: volumes, faces that
// conform, edges.

#pragma once

#include "core/array.hpp"
#include "core/vec3.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <set>

namespace elastogen::test {

using elastogen::dot;  // other tests have one of vectors of any length

inline Vec3 place(const Array<double>& x, int32_t node) {
  return {x(node, 0), x(node, 1), x(node, 2)};
}

/// Six times the volume between the corners of a tetrahedron [m^3].
template <class Mesh>
double tet_determinant(const Mesh& mesh, int64_t e) {
  const Vec3 origin = place(mesh.rest, mesh.elements(e, 0));
  const auto edge = [&](int k) { return minus(place(mesh.rest, mesh.elements(e, k)), origin); };
  return dot(edge(1), cross(edge(2), edge(3)));
}

/// Six times the volumes: exact where coordinates are short in binary.
struct Determinants {
  double sum = 0, least = std::numeric_limits<double>::infinity(), most = 0;
};

template <class Mesh>
Determinants determinants(const Mesh& mesh) {
  Determinants all;
  for (int64_t e = 0; e < mesh.elements.rows(); ++e) {
    const double d = tet_determinant(mesh, e);
    all.sum += d;
    all.least = std::min(all.least, d);
    all.most = std::max(all.most, d);
  }
  return all;
}

/// Faces of a mesh of tetrahedra: with one on each side, with one in all, and all others.
struct Faces {
  int64_t inner = 0, border = 0, wrong = 0;
};

template <class Mesh>
Faces faces(const Mesh& mesh) {
  constexpr int kFace[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};  // seen from outside
  std::map<std::array<int32_t, 3>, std::array<int, 2>> sides;  // how often in each sense
  for (int64_t e = 0; e < mesh.elements.rows(); ++e)
    for (const auto& face : kFace) {
      std::array<int32_t, 3> nodes;
      for (size_t k = 0; k < 3; ++k) nodes[k] = mesh.elements(e, face[k]);
      std::rotate(nodes.begin(), std::min_element(nodes.begin(), nodes.end()), nodes.end());
      const bool turned = nodes[1] > nodes[2];
      if (turned) std::swap(nodes[1], nodes[2]);
      ++sides[nodes][turned];
    }
  Faces all;
  for (const auto& [nodes, count] : sides) {
    if (count[0] == 1 && count[1] == 1)
      ++all.inner;
    else if (count[0] + count[1] == 1)
      ++all.border;
    else
      ++all.wrong;
  }
  return all;
}

template <class Mesh>
int64_t edge_count(const Mesh& mesh) {
  std::set<std::pair<int32_t, int32_t>> edges;
  for (int64_t e = 0; e < mesh.elements.rows(); ++e)
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < a; ++b)
        edges.insert(std::minmax(mesh.elements(e, a), mesh.elements(e, b)));
  return int64_t(edges.size());
}

}  // namespace elastogen::test
