// SPDX-License-Identifier: Apache-2.0
#include "voxelize/triangle_gap.hpp"

#include "core/vec3.hpp"
#include "voxelize/labels.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

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

/// Whether the segment p q passes through the interior of a triangle.
bool pierces(const Vec3& p, const Vec3& q, const Vec3 c[3]) {
  const Vec3 normal = cross(minus(c[1], c[0]), minus(c[2], c[0]));
  const double above = dot(normal, minus(p, c[0])), below = dot(normal, minus(q, c[0]));
  if (above * below >= 0) return false;
  const Vec3 x = plus(p, scaled(minus(q, p), above / (above - below)));
  for (int k = 0; k < 3; ++k)
    if (dot(cross(normal, minus(c[(k + 1) % 3], c[k])), minus(x, c[k])) < 0) return false;
  return true;
}

double box_gap2(const Box& a, const Box& b) {
  double sum = 0;
  for (size_t d = 0; d < 3; ++d) {
    const double gap = std::max({a.lower[d] - b.upper[d], b.lower[d] - a.upper[d], 0.0});
    sum += gap * gap;
  }
  return sum;
}

/// Finds the nearest triangles of two trees, nearer halves first.
class Search {
 public:
  Search(const TriangleBoxes& a, const TriangleBoxes& b, double enough)
      : a_(a), b_(b), enough2_(enough * enough) {
    visit(0, 0);
  }

  double least2 = std::numeric_limits<double>::infinity();
  int32_t first = 0, second = 0;  // places in the trees' order

 private:
  void visit(int32_t m, int32_t n) {
    constexpr double kWorth = 0.98;  // share of the squared distance: 1 % of the distance
    const TriangleBoxes::Node &a = a_.node(m), &b = b_.node(n);
    if (least2 <= enough2_ || box_gap2(a.box, b.box) > kWorth * least2) return;
    if (a.right < 0 && b.right < 0) return compare(a, b);
    const bool halve_a = b.right < 0 || (a.right >= 0 && a.last - a.first >= b.last - b.first);
    const int32_t parts[2][2] = {{halve_a ? m + 1 : m, halve_a ? n : n + 1},
                                 {halve_a ? a.right : m, halve_a ? n : b.right}};
    double gap[2];
    for (int k = 0; k < 2; ++k)
      gap[k] = box_gap2(a_.node(parts[k][0]).box, b_.node(parts[k][1]).box);
    const int nearer = gap[1] < gap[0];
    for (const int k : {nearer, 1 - nearer}) visit(parts[k][0], parts[k][1]);
  }

  void compare(const TriangleBoxes::Node& a, const TriangleBoxes::Node& b) {
    for (int32_t i = a.first; i < a.last; ++i)
      for (int32_t j = b.first; j < b.last; ++j) {
        const double gap2 = triangle_gap2(a_.triangle(i).data(), b_.triangle(j).data());
        if (gap2 < least2) least2 = gap2, first = i, second = j;
      }
  }

  const TriangleBoxes &a_, &b_;
  double enough2_;
};

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

TriangleBoxes::TriangleBoxes(std::vector<std::array<Vec3, 3>> triangles)
    : triangles_(std::move(triangles)), number_(triangles_.size()) {
  std::iota(number_.begin(), number_.end(), 0);
  build(0, int32_t(triangles_.size()));
  std::vector<std::array<Vec3, 3>> sorted;
  for (const int32_t n : number_) sorted.push_back(triangles_[size_t(n)]);
  triangles_ = std::move(sorted);
}

int32_t TriangleBoxes::build(int32_t first, int32_t last) {
  constexpr int32_t kLeaf = 4;
  const auto n = int32_t(nodes_.size());
  // the box of all its triangles
  nodes_.push_back({{}, first, last, -1});
  Box box;
  for (int32_t i = first; i < last; ++i)
    for (const Vec3& p : triangles_[size_t(number_[size_t(i)])]) box.add(p);
  nodes_[size_t(n)].box = box;
  if (last - first <= kLeaf) return n;
  // split at the median along the longest axis; of equal places the first triangles go left
  size_t axis = 0;
  for (size_t d = 1; d < 3; ++d)
    if (box.extent(int(d)) > box.extent(int(axis))) axis = d;
  const auto middle = [&](int32_t t) {
    const auto& c = triangles_[size_t(t)];
    return c[0][axis] + c[1][axis] + c[2][axis];
  };
  const int32_t half = (first + last) / 2;
  std::nth_element(number_.begin() + first, number_.begin() + half, number_.begin() + last,
                   [&](int32_t a, int32_t b) {
                     const double at_a = middle(a), at_b = middle(b);
                     return at_a < at_b || (at_a == at_b && a < b);
                   });
  // the first child follows its parent, the place of the second is stored
  build(first, half);
  const int32_t right = build(half, last);
  nodes_[size_t(n)].right = right;
  return n;
}

TriangleGap nearest(const TriangleBoxes& a, const TriangleBoxes& b, double enough) {
  const Search search(a, b, enough);
  return {a.number(search.first), b.number(search.second), std::sqrt(search.least2)};
}

}  // namespace elastogen
