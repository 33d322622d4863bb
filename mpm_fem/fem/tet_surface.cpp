// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/fem/tet_surface.hpp"

#include "core/error.hpp"
#include "core/vec3.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

namespace elastogen::fem {
namespace {

struct TetFace {
  std::array<int32_t, 3> nodes;  ///< in ascending order
  int64_t element;
  int side;
};

/// Faces that no other tetrahedron has, in the order of their tetrahedra.
std::vector<TetFace> outer_faces(const ElementMesh& mesh) {
  std::vector<TetFace> faces;
  for (int64_t e = 0; e < mesh.elements.rows(); ++e)
    for (int side = 0; side < 4; ++side) {
      TetFace face{{}, e, side};
      for (size_t c = 0; c < 3; ++c) face.nodes[c] = mesh.elements(e, kTetFaces[side][c]);
      std::sort(face.nodes.begin(), face.nodes.end());
      faces.push_back(face);
    }
  std::stable_sort(faces.begin(), faces.end(),
                   [](const TetFace& a, const TetFace& b) { return a.nodes < b.nodes; });
  std::vector<TetFace> outer;
  for (size_t k = 0; k < faces.size(); ++k) {
    const bool before = k > 0 && faces[k - 1].nodes == faces[k].nodes;
    const bool after = k + 1 < faces.size() && faces[k + 1].nodes == faces[k].nodes;
    if (!before && !after) outer.push_back(faces[k]);
  }
  std::sort(outer.begin(), outer.end(), [](const TetFace& a, const TetFace& b) {
    return a.element != b.element ? a.element < b.element : a.side < b.side;
  });
  return outer;
}

void check_tets(const ElementMesh& mesh) {
  const int64_t nodes = mesh.elements.cols();
  ELASTOGEN_CHECK(nodes == 4 || nodes == 10, "tetrahedra of 4 or 10 nodes are expected, got ",
                  nodes, " columns");
}

/// Root of the mean of twice the area.
double plane_edge(const ElementMesh& mesh) {
  double twice = 0;
  for (int64_t e = 0; e < mesh.elements.rows(); ++e) {
    const double *a = mesh.rest.row(mesh.elements(e, 0)), *b = mesh.rest.row(mesh.elements(e, 1));
    const double* c = mesh.rest.row(mesh.elements(e, 2));
    twice += (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
  }
  return std::sqrt(twice / double(mesh.elements.rows()));
}

}  // namespace

Array<int32_t> outer_triangles(const ElementMesh& mesh) {
  if (is_plane(mesh.element)) return mesh.elements;
  check_tets(mesh);
  const bool quadratic = mesh.elements.cols() == 10;
  std::vector<int32_t> corners;
  for (const TetFace& face : outer_faces(mesh)) {
    const int32_t* node = mesh.elements.row(face.element);
    int32_t a[3], m[3] = {};  // m[k] between a[k] and the next
    for (int k = 0; k < 3; ++k) {
      a[k] = node[kTetFaces[face.side][k]];
      if (quadratic) m[k] = node[kTetFaceMiddles[face.side][k]];
    }
    if (quadratic)
      corners.insert(corners.end(),
                     {a[0], m[0], m[2], m[0], a[1], m[1], m[2], m[1], a[2], m[0], m[1], m[2]});
    else
      corners.insert(corners.end(), a, a + 3);
  }
  Array<int32_t> triangles(int64_t(corners.size() / 3), 3);
  std::copy(corners.begin(), corners.end(), triangles.data());
  return triangles;
}

Array<double> rim_area(const ElementMesh& mesh) {
  std::map<std::pair<int32_t, int32_t>, int> triangles;  // of each edge
  for (int64_t e = 0; e < mesh.elements.rows(); ++e)
    for (int c = 0; c < 3; ++c)
      ++triangles[std::minmax(mesh.elements(e, c), mesh.elements(e, (c + 1) % 3))];
  Array<double> area(mesh.rest.rows());
  for (const auto& [edge, count] : triangles) {
    if (count > 1) continue;
    const double *a = mesh.rest.row(edge.first), *b = mesh.rest.row(edge.second);
    const double half = std::hypot(b[0] - a[0], b[1] - a[1]) / 2;
    area(edge.first) += half, area(edge.second) += half;
  }
  return area;
}

double mean_edge(const ElementMesh& mesh) {
  if (is_plane(mesh.element)) return plane_edge(mesh);
  check_tets(mesh);
  double six_volumes = 0;
  for (int64_t e = 0; e < mesh.elements.rows(); ++e) {
    Vec3 x[4];
    for (int c = 0; c < 4; ++c)
      for (int d = 0; d < 3; ++d) x[c][size_t(d)] = mesh.rest(mesh.elements(e, c), d);
    six_volumes += dot(minus(x[1], x[0]), cross(minus(x[2], x[0]), minus(x[3], x[0])));
  }
  return std::cbrt(six_volumes / double(mesh.elements.rows()));
}

}  // namespace elastogen::fem
