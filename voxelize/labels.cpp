// SPDX-License-Identifier: Apache-2.0
#include "voxelize/labels.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "core/vec3.hpp"

#include <algorithm>
#include <bit>
#include <limits>
#include <numeric>

namespace elastogen {
namespace {

constexpr int64_t kLeaf = 8;  // triangles in a leaf

double clamp01(double t) {
  return std::clamp(t, 0.0, 1.0);
}

double segment_distance2(const Vec3& a, const Vec3& b, const Vec3& p) {
  const Vec3 edge = minus(b, a), from = minus(p, a);
  const double size = dot(edge, edge);
  const Vec3 gap = minus(from, scaled(edge, size > 0 ? clamp01(dot(from, edge) / size) : 0));
  return dot(gap, gap);
}

double box_distance2(const Box& box, const Vec3& p) {
  double sum = 0;
  for (size_t d = 0; d < 3; ++d) {
    const double gap = std::max({box.lower[d] - p[d], p[d] - box.upper[d], 0.0});
    sum += gap * gap;
  }
  return sum;
}

/// Squared distance, increased by a millionth if the triangle faces the point.
double cost(const std::array<Vec3, 3>& c, const Vec3& point) {
  const Vec3 normal = cross(minus(c[1], c[0]), minus(c[2], c[0]));
  const double d = triangle_distance2(c.data(), point);
  return dot(normal, minus(point, c[0])) > 0 ? d * (1 + 1e-6) : d;
}

/// A tree of boxes over triangles, halved along the longest edge.
class TriangleTree {
 public:
  TriangleTree(const Surface& surface, std::vector<int32_t> triangles)
      : surface_(surface), order_(std::move(triangles)) {
    const auto leaves = (uint64_t(order_.size()) + kLeaf - 1) / kLeaf;
    boxes_.resize(2 * std::bit_ceil(std::max<uint64_t>(leaves, 1)));
    build(0, 0, int64_t(order_.size()));
  }

  int32_t find(const Vec3& point) const {
    Best best;
    search(0, 0, int64_t(order_.size()), point, best);
    return best.triangle;
  }

 private:
  struct Best {
    double distance2 = std::numeric_limits<double>::infinity();
    int32_t triangle = std::numeric_limits<int32_t>::max();
  };

  std::array<Vec3, 3> corners(int32_t t) const {
    std::array<Vec3, 3> result;
    for (int k = 0; k < 3; ++k) {
      const double* x = surface_.vertices.row(surface_.triangles(t, k));
      result[size_t(k)] = {x[0], x[1], x[2]};
    }
    return result;
  }
  double middle(int32_t t, size_t axis) const {
    const auto c = corners(t);
    return c[0][axis] + c[1][axis] + c[2][axis];
  }

  void build(size_t node, int64_t first, int64_t last) {
    Box& box = boxes_[node];
    for (int64_t i = first; i < last; ++i)
      for (const Vec3& p : corners(order_[size_t(i)])) box.add(p);
    if (last - first <= kLeaf) return;
    size_t axis = 0;
    for (size_t d = 1; d < 3; ++d)
      if (box.extent(int(d)) > box.extent(int(axis))) axis = d;
    const int64_t half = (first + last) / 2;
    std::nth_element(order_.begin() + first, order_.begin() + half, order_.begin() + last,
                     [&](int32_t a, int32_t b) {
                       const double at_a = middle(a, axis), at_b = middle(b, axis);
                       return at_a < at_b || (at_a == at_b && a < b);
                     });
    build(2 * node + 1, first, half);
    build(2 * node + 2, half, last);
  }

  void search(size_t node, int64_t first, int64_t last, const Vec3& point, Best& best) const {
    if (last - first <= kLeaf) {
      for (int64_t i = first; i < last; ++i) {
        const int32_t t = order_[size_t(i)];
        const double d = cost(corners(t), point);
        if (d < best.distance2 || (d == best.distance2 && t < best.triangle)) best = {d, t};
      }
      return;
    }
    const int64_t half = (first + last) / 2;
    const size_t lower = 2 * node + 1, upper = lower + 1;
    const double to_lower = box_distance2(boxes_[lower], point);
    const double to_upper = box_distance2(boxes_[upper], point);
    const bool lower_first = to_lower <= to_upper;
    // a little more than the best, so that rounding does not hide a triangle that is equally near
    const auto worth = [&](double d) { return d <= best.distance2 * (1 + 1e-12); };
    if (lower_first && worth(to_lower)) search(lower, first, half, point, best);
    if (worth(to_upper)) search(upper, half, last, point, best);
    if (!lower_first && worth(to_lower)) search(lower, first, half, point, best);
  }

  const Surface& surface_;
  std::vector<int32_t> order_;
  std::vector<Box> boxes_;  // children of node n are 2 n + 1 and 2 n + 2
};

/// One tree for each part, or one for all triangles.
std::vector<TriangleTree> trees_of(const Surface& surface, size_t parts) {
  std::vector<std::vector<int32_t>> triangles(parts);
  for (int64_t t = 0; t < surface.triangles.rows(); ++t) {
    const int32_t part = surface.part.empty() ? 0 : surface.part(t);
    if (part >= 0) triangles[size_t(part)].push_back(int32_t(t));
  }
  std::vector<TriangleTree> trees;
  for (std::vector<int32_t>& some : triangles) trees.emplace_back(surface, std::move(some));
  return trees;
}

}  // namespace

double triangle_distance2(const Vec3 corner[3], const Vec3& point) {
  const Vec3 &a = corner[0], &b = corner[1], &c = corner[2];
  const Vec3 normal = cross(minus(b, a), minus(c, a));
  const double size = dot(normal, normal);
  // above the inside of the triangle its plane is nearest, else an edge is
  bool inside = size > 0;
  for (int k = 0; k < 3 && inside; ++k) {
    const Vec3 edge = minus(corner[(k + 1) % 3], corner[k]);
    inside = dot(cross(normal, edge), minus(point, corner[k])) >= 0;
  }
  if (inside) {
    const double height = dot(normal, minus(point, a));
    return height * height / size;
  }
  return std::min({segment_distance2(a, b, point), segment_distance2(b, c, point),
                   segment_distance2(c, a, point)});
}

Vec3 nearest_weights(const Vec3 corner[3], const Vec3& point) {
  const Vec3 a = minus(corner[1], corner[0]), b = minus(corner[2], corner[0]);
  const Vec3 p = minus(point, corner[0]), normal = cross(a, b);
  const double size = dot(normal, normal);
  if (!(size > 0)) return {1.0 / 3, 1.0 / 3, 1.0 / 3};
  Vec3 w = {0, dot(cross(p, b), normal) / size, dot(cross(a, p), normal) / size};
  w[0] = 1 - w[1] - w[2];
  if (*std::ranges::min_element(w) >= 0) return w;
  // outside: the nearest place is on an edge
  double nearest = 1e300;
  for (size_t k = 0; k < 3; ++k) {
    const Vec3 edge = minus(corner[(k + 1) % 3], corner[k]), from = minus(point, corner[k]);
    const double length = dot(edge, edge);
    const double t = length > 0 ? std::clamp(dot(from, edge) / length, 0.0, 1.0) : 0;
    const Vec3 gap = minus(from, scaled(edge, t));
    if (dot(gap, gap) >= nearest) continue;
    nearest = dot(gap, gap);
    w = {};
    w[k] = 1 - t;
    w[(k + 1) % 3] = t;
  }
  return w;
}

Array<int32_t> nearest_triangles(const VoxelGrid& grid, const Surface& surface) {
  ELASTOGEN_CHECK(surface.triangles.rows() > 0, "the surface has no triangle");
  const std::vector<TriangleTree> trees =
      trees_of(surface, std::max<size_t>(1, grid.part_shift.size()));
  Array<int32_t> nearest(grid.voxel_count());
  for_each(
      grid.voxel_count(),
      [&](int64_t v) {
        const double* lower = grid.rest.row(grid.corners(v, 0));
        const double half = grid.h / 2;
        const auto part = size_t(grid.part.empty() ? 0 : grid.part(v));
        nearest(v) = trees[part].find({lower[0] + half, lower[1] + half, lower[2] + half});
      },
      64);
  return nearest;
}

Array<int32_t> parts_of_carried(const Body& body) {
  const Surface& surface = body.surface;
  if (surface.part.empty()) return {};
  Array<int32_t> part(body.carried.rows());
  part.fill(-1);
  for (int64_t t = 0; body.is_asset && t < surface.triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k) {
      int32_t& of_vertex = part(surface.triangles(t, k));
      of_vertex = std::max(of_vertex, surface.part(t));
    }
  std::vector<int32_t> known;
  for (int64_t t = 0; t < surface.triangles.rows(); ++t)
    if (surface.part(t) >= 0) known.push_back(int32_t(t));
  const TriangleTree tree(surface, std::move(known));
  for_each(
      part.rows(),
      [&](int64_t p) {
        const double* x = body.carried.row(p);
        if (part(p) < 0) part(p) = surface.part(tree.find({x[0], x[1], x[2]}));
      },
      64);
  return part;
}

}  // namespace elastogen
