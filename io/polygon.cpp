// SPDX-License-Identifier: Apache-2.0
#include "io/polygon.hpp"

#include <cmath>
#include <numeric>

namespace elastogen {
namespace {

using Vec2 = std::array<double, 2>;

double cross(const Vec2& a, const Vec2& b, const Vec2& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/// The corners in the coordinate plane nearest to the polygon's own, counter-clockwise.
std::vector<Vec2> flattened(const std::vector<Vec3>& corners) {
  const size_t n = corners.size();
  const Vec3& o = corners[0];

  // Newell's normal: exact for planar polygons, a mean for others
  Vec3 normal = {};
  for (size_t k = 0; k < n; ++k) {
    const Vec3 &a = corners[k], &b = corners[(k + 1) % n];
    for (int d = 0; d < 3; ++d) {
      const int i = (d + 1) % 3, j = (d + 2) % 3;
      normal[d] += (a[i] - o[i]) * (b[j] - o[j]) - (a[j] - o[j]) * (b[i] - o[i]);
    }
  }

  int axis = 0;
  for (int d = 1; d < 3; ++d)
    if (std::abs(normal[d]) > std::abs(normal[axis])) axis = d;
  const int i = (axis + 1) % 3, j = (axis + 2) % 3;
  const double sign = normal[axis] < 0 ? -1 : 1;
  std::vector<Vec2> flat;
  for (const Vec3& p : corners) flat.push_back({sign * (p[i] - o[i]), p[j] - o[j]});
  return flat;
}

/// Whether no triangle of the fan from the first corner is turned over.
bool fan_is_right(const std::vector<Vec2>& p) {
  for (size_t k = 2; k < p.size(); ++k)
    if (cross(p[0], p[k - 1], p[k]) < 0) return false;
  return true;
}

/// Whether corner k of the ring can be cut off: it is convex and its triangle has no other corner.
bool is_ear(const std::vector<Vec2>& p, const std::vector<int>& ring, size_t k) {
  const size_t n = ring.size();
  const Vec2 &a = p[ring[(k + n - 1) % n]], &b = p[ring[k]], &c = p[ring[(k + 1) % n]];
  if (cross(a, b, c) <= 0) return false;
  for (const int other : ring) {
    const Vec2& q = p[other];
    if (q == a || q == b || q == c) continue;
    if (cross(a, b, q) >= 0 && cross(b, c, q) >= 0 && cross(c, a, q) >= 0) return false;
  }
  return true;
}

std::vector<int> fan(const std::vector<int>& ring) {
  std::vector<int> triangles;
  for (size_t k = 2; k < ring.size(); ++k)
    triangles.insert(triangles.end(), {ring[0], ring[k - 1], ring[k]});
  return triangles;
}

}  // namespace

std::vector<int> triangulate(const std::vector<Vec3>& corners) {
  std::vector<int> ring(corners.size());
  std::iota(ring.begin(), ring.end(), 0);
  if (ring.size() <= 3 || ring.size() > kMaxEarCorners) return fan(ring);
  const std::vector<Vec2> flat = flattened(corners);
  if (fan_is_right(flat)) return fan(ring);

  std::vector<int> triangles;
  size_t k = 0, misses = 0;
  while (ring.size() > 3 && misses < ring.size()) {
    const size_t n = ring.size();
    k %= n;
    if (!is_ear(flat, ring, k)) {
      ++k, ++misses;
      continue;
    }
    triangles.insert(triangles.end(), {ring[(k + n - 1) % n], ring[k], ring[(k + 1) % n]});
    ring.erase(ring.begin() + int64_t(k));
    misses = 0;
  }

  // a ring without an ear crosses itself or has no area
  const std::vector<int> rest = fan(ring);
  triangles.insert(triangles.end(), rest.begin(), rest.end());
  return triangles;
}

}  // namespace elastogen
