// SPDX-License-Identifier: Apache-2.0
#include "io/normal_deltas.hpp"

#include "core/error.hpp"
#include "core/vec3.hpp"

#include <cmath>

namespace elastogen {

namespace {

double length(const Vec3& a) {
  return std::hypot(a[0], a[1], a[2]);
}

/// Edges of a triangle, its unit normal and twice its area.
struct Frame {
  Vec3 e1, e2, m;
  double area;

  Frame(const Vec3& a, const Vec3& b, const Vec3& c) : e1(minus(b, a)), e2(minus(c, a)) {
    m = cross(e1, e2);
    area = length(m);
    for (double& x : m) x /= area;
  }
  bool valid() const { return area > 0 && std::isfinite(area); }
};

/// n carried from a triangle at rest to its moved position.
Vec3 carried(const Frame& rest, const Frame& moved, const Vec3& n) {
  const double a = dot(n, rest.e1) / moved.area, b = dot(n, rest.e2) / moved.area;
  const double c = dot(n, rest.m);
  const Vec3 first = cross(moved.e2, moved.m), second = cross(moved.m, moved.e1);
  Vec3 result;
  for (int d = 0; d < 3; ++d) result[d] = a * first[d] + b * second[d] + c * moved.m[d];
  return result;
}

Vec3 normal(const Mesh& mesh, size_t vertex) {
  const auto& n = mesh.normal[vertex];
  return {n[0], n[1], n[2]};
}

}  // namespace

void normal_deltas(const Mesh& mesh, In<double> displacement, Out<float> delta) {
  const auto positions = int64_t(mesh.position.size()), drawn = int64_t(mesh.normal.size());
  ELASTOGEN_CHECK(displacement.is(positions, 3), "displacement must be (", positions, ", 3), got ",
                  displacement);
  ELASTOGEN_CHECK(delta.is(drawn, 3), "delta must be (", drawn, ", 3), got ", delta);
  std::vector<Vec3> sum(size_t(drawn), Vec3{});
  for (const TriangleGroup& group : mesh.groups) {
    for (size_t t = 0; t + 2 < group.corner.size(); t += 3) {
      Vec3 X[3], x[3];
      for (int k = 0; k < 3; ++k) {
        const int32_t p = mesh.position_of[size_t(group.corner[t + size_t(k)])];
        X[k] = x[k] = mesh.position[size_t(p)];
        for (int d = 0; d < 3; ++d) x[k][d] += displacement(p, d);
      }
      const Frame rest(X[0], X[1], X[2]), moved(x[0], x[1], x[2]);
      if (!rest.valid() || !moved.valid()) continue;
      for (int k = 0; k < 3; ++k) {
        const auto v = size_t(group.corner[t + size_t(k)]);
        const Vec3 n = carried(rest, moved, normal(mesh, v));
        for (int d = 0; d < 3; ++d) sum[v][d] += rest.area * n[d];
      }
    }
  }

  // the mean over triangles, scaled to the length of the normal at rest
  for (int64_t v = 0; v < drawn; ++v) {
    const Vec3 n = normal(mesh, size_t(v)), s = sum[size_t(v)];
    const double from = length(s), to = length(n);
    for (int d = 0; d < 3; ++d) delta(v, d) = from > 0 ? float(s[d] * (to / from) - n[d]) : 0;
  }
}

}  // namespace elastogen
