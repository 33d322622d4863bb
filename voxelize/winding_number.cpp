// SPDX-License-Identifier: Apache-2.0
#include "voxelize/winding_number.hpp"

#include "core/vec3.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace elastogen {
namespace {

constexpr int32_t kLeafTriangles = 8;
constexpr double kFar = 3;  // distance from which on a cluster is a dipole [radii]

Vec3 area_vector(const WindingNumber::Triangle& t) {
  return scaled(cross(minus(t.corner[1], t.corner[0]), minus(t.corner[2], t.corner[0])), 0.5);
}

double middle(const WindingNumber::Triangle& t, int d) {
  return t.corner[0][d] + t.corner[1][d] + t.corner[2][d];
}

}  // namespace

double winding(const WindingNumber::Triangle& triangle, const Vec3& q) {
  const Vec3 a = minus(triangle.corner[0], q), b = minus(triangle.corner[1], q),
             c = minus(triangle.corner[2], q);
  const double la = norm(a), lb = norm(b), lc = norm(c);
  const double volume = dot(a, cross(b, c));
  const double cosine = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
  return std::atan2(volume, cosine) / (2 * std::numbers::pi);
}

WindingNumber::WindingNumber(std::vector<Triangle> triangles) : triangles_(std::move(triangles)) {
  nodes_.reserve(triangles_.size());
  if (!triangles_.empty()) build(0, static_cast<int32_t>(triangles_.size()));
}

WindingNumber::Node WindingNumber::summary(int32_t first, int32_t last) const {
  Node node;
  node.first = first;
  node.last = last;
  double area = 0;
  for (int32_t t = first; t < last; ++t) {
    const Vec3 vector = area_vector(triangles_[t]);
    const double a = norm(vector);
    node.dipole = plus(node.dipole, vector);
    for (int d = 0; d < 3; ++d) node.centre[d] += a * middle(triangles_[t], d) / 3;
    area += a;
  }
  node.centre = area > 0 ? scaled(node.centre, 1 / area) : triangles_[first].corner[0];
  for (int32_t t = first; t < last; ++t)
    for (const Vec3& p : triangles_[t].corner)
      node.radius = std::max(node.radius, norm(minus(p, node.centre)));
  return node;
}

int32_t WindingNumber::build(int32_t first, int32_t last) {
  const auto index = static_cast<int32_t>(nodes_.size());
  nodes_.push_back(summary(first, last));
  if (last - first <= kLeafTriangles) return index;

  // halves along the longest axis of the triangles' centres
  Box box;
  for (int32_t t = first; t < last; ++t)
    box.add({middle(triangles_[t], 0), middle(triangles_[t], 1), middle(triangles_[t], 2)});
  int axis = 0;
  for (int d = 1; d < 3; ++d)
    if (box.extent(d) > box.extent(axis)) axis = d;
  const int32_t half = first + (last - first) / 2;
  std::nth_element(
      triangles_.begin() + first, triangles_.begin() + half, triangles_.begin() + last,
      [&](const Triangle& a, const Triangle& b) { return middle(a, axis) < middle(b, axis); });
  build(first, half);
  const int32_t right = build(half, last);
  nodes_[index].right = right;
  return index;
}

double WindingNumber::operator()(const Vec3& q) const {
  double sum = 0;
  int32_t stack[64] = {0};
  int depth = nodes_.empty() ? 0 : 1;
  while (depth > 0) {
    const int32_t index = stack[--depth];
    const Node& node = nodes_[index];
    const Vec3 r = minus(node.centre, q);
    const double distance = norm(r);
    if (distance > kFar * node.radius) {
      sum += dot(node.dipole, r) / (4 * std::numbers::pi * distance * distance * distance);
    } else if (node.right < 0) {
      for (int32_t t = node.first; t < node.last; ++t) sum += winding(triangles_[t], q);
    } else {
      stack[depth++] = node.right;
      stack[depth++] = index + 1;
    }
  }
  return sum;
}

}  // namespace elastogen
