// SPDX-License-Identifier: Apache-2.0
#include "voxelize/cell_lines.hpp"

#include <tuple>

namespace elastogen {
namespace {

double area2(const Vec3& a, const Vec3& b, const Vec3& p, int u, int v) {
  return (b[u] - a[u]) * (p[v] - a[v]) - (b[v] - a[v]) * (p[u] - a[u]);
}

/// Whether p is left of a b in the plane of u and v. A point on the edge is left of one direction
/// only, and both triangles of an edge compute the same number.
bool left_of(const Vec3& a, const Vec3& b, const Vec3& p, int u, int v) {
  if (std::tie(a[u], a[v]) < std::tie(b[u], b[v])) return area2(a, b, p, u, v) >= 0;
  return !(area2(b, a, p, u, v) >= 0);
}

}  // namespace

LocalTriangles solid_triangles(const LatticeMesh& mesh, const SurfaceCells& cells, int64_t cell) {
  LocalTriangles local;
  for (int64_t i = cells.first[cell]; i < cells.first[cell + 1]; ++i) {
    const auto t = size_t(cells.triangle[i]);
    if (mesh.role[t] != Role::kSolid) continue;
    WindingNumber::Triangle& triangle = local.emplace_back();
    for (int k = 0; k < 3; ++k)
      for (int d = 0; d < 3; ++d)
        triangle.corner[k][d] = mesh.vertices[mesh.triangles[t][k]][d] - cells.coord[cell][d];
  }
  return local;
}

void find_crossings(const LocalTriangles& triangles, const Vec3& p, int axis, Crossings& result) {
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  result.clear();
  for (const auto& [corner] : triangles) {
    const bool left = left_of(corner[0], corner[1], p, u, v);
    if (left != left_of(corner[1], corner[2], p, u, v) ||
        left != left_of(corner[2], corner[0], p, u, v))
      continue;
    double place = 0, sum = 0;
    for (int k = 0; k < 3; ++k) {
      const double weight = area2(corner[(k + 1) % 3], corner[(k + 2) % 3], p, u, v);
      place += weight * corner[k][axis];
      sum += weight;
    }
    if (sum != 0) result.push_back({place / sum, left ? -1 : 1});
  }
  std::sort(result.begin(), result.end());
}

int step_between(const Crossings& crossings, double a, double b) {
  int sum = 0;
  for (const Crossing& c : crossings) {
    if (c.place > a && c.place <= b) sum += c.step;
    if (c.place > b && c.place <= a) sum -= c.step;
  }
  return sum;
}

}  // namespace elastogen
