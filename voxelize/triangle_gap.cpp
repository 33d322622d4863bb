// SPDX-License-Identifier: Apache-2.0
#include "voxelize/triangle_gap.hpp"

#include "core/vec3.hpp"
#include "voxelize/labels.hpp"

#include <algorithm>
#include <limits>

namespace elastogen {
namespace {

/// Squared distance of the segments a b and p q (Ericson, Real-Time Collision Detection, 5.1.9).
double segment_gap2(const Vec3& a, const Vec3& b, const Vec3& p, const Vec3& q) {
  const Vec3 u = minus(b, a), v = minus(q, p), w = minus(a, p);
  const double uu = dot(u, u), uv = dot(u, v), vv = dot(v, v), uw = dot(u, w), vw = dot(v, w);
  const auto clamp = [](double t) { return std::clamp(t, 0.0, 1.0); };
  const double det = uu * vv - uv * uv;
  double s = det > 1e-14 * uu * vv ? clamp((uv * vw - uw * vv) / det) : 0;
  const double t = vv > 0 ? clamp((uv * s + vw) / vv) : 0;
  if (uu > 0) s = clamp((uv * t - uw) / uu);
  const Vec3 gap = plus(w, minus(scaled(u, s), scaled(v, t)));
  return dot(gap, gap);
}

/// Whether the segment p q passes through the inside of a triangle.
bool pierces(const Vec3& p, const Vec3& q, const Vec3 c[3]) {
  const Vec3 normal = cross(minus(c[1], c[0]), minus(c[2], c[0]));
  const double above = dot(normal, minus(p, c[0])), below = dot(normal, minus(q, c[0]));
  if (above * below >= 0) return false;
  const Vec3 x = plus(p, scaled(minus(q, p), above / (above - below)));
  for (int k = 0; k < 3; ++k)
    if (dot(cross(normal, minus(c[(k + 1) % 3], c[k])), minus(x, c[k])) < 0) return false;
  return true;
}

}  // namespace

double triangle_gap2(const Vec3 a[3], const Vec3 b[3]) {
  double gap2 = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    const Vec3 &p = a[i], &q = a[(i + 1) % 3], &r = b[i], &s = b[(i + 1) % 3];
    if (pierces(p, q, b) || pierces(r, s, a)) return 0;
    gap2 = std::min({gap2, triangle_distance2(b, p), triangle_distance2(a, r)});
    for (int k = 0; k < 3; ++k) gap2 = std::min(gap2, segment_gap2(p, q, b[k], b[(k + 1) % 3]));
  }
  return gap2;
}

}  // namespace elastogen
