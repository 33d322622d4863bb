// SPDX-License-Identifier: Apache-2.0
#include "voxelize/nearest_voxel.hpp"

#include <algorithm>
#include <bit>
#include <limits>

namespace elastogen {
namespace {

double distance2(const Box& box, const Vec3& p) {
  double sum = 0;
  for (int d = 0; d < 3; ++d) {
    const double gap = std::max({box.lower[d] - p[d], p[d] - box.upper[d], 0.0});
    sum += gap * gap;
  }
  return sum;
}

Box cube(In<int32_t> coords, int64_t v) {
  Box box;
  for (int upper = 0; upper < 2; ++upper)
    box.add(
        {coords(v, 0) + double(upper), coords(v, 1) + double(upper), coords(v, 2) + double(upper)});
  return box;
}

}  // namespace

NearestVoxel::NearestVoxel(In<int32_t> coords, In<int32_t> part, int32_t wanted) : coords_(coords) {
  const auto brick = [&](int64_t row) {
    return Coord{coords(row, 0) >> 3, coords(row, 1) >> 3, coords(row, 2) >> 3};
  };
  for (int64_t v = 0; v < coords.rows; ++v) {
    if (part.rows > 0 && part(v) != wanted) continue;
    const bool goes_on = !bricks_.empty() && bricks_.back().second == v && brick(v) == brick(v - 1);
    if (goes_on)
      ++bricks_.back().second;
    else
      bricks_.emplace_back(v, v + 1);
  }
  const auto bricks = static_cast<int64_t>(bricks_.size());
  if (bricks == 0) return;
  boxes_.resize(2 * std::bit_ceil(static_cast<uint64_t>(bricks)));
  build(0, 0, bricks);
}

Box NearestVoxel::build(int64_t node, int64_t first, int64_t last) {
  Box box;
  if (last - first == 1) {
    for (int64_t v = bricks_[first].first; v < bricks_[first].second; ++v) {
      const Box one = cube(coords_, v);
      box.add(one.lower);
      box.add(one.upper);
    }
  } else {
    const int64_t half = (first + last) / 2;
    for (const Box& part : {build(2 * node + 1, first, half), build(2 * node + 2, half, last)}) {
      box.add(part.lower);
      box.add(part.upper);
    }
  }
  return boxes_[node] = box;
}

void NearestVoxel::search(int64_t node, int64_t first, int64_t last, const Vec3& point,
                          Best& best) const {
  if (last - first == 1) {
    for (int64_t v = bricks_[first].first; v < bricks_[first].second; ++v) {
      const double d = distance2(cube(coords_, v), point);
      if (d < best.distance2 || (d == best.distance2 && v < best.voxel)) best = {d, v};
    }
    return;
  }
  const int64_t half = (first + last) / 2, lower = 2 * node + 1, upper = 2 * node + 2;
  const double to_lower = distance2(boxes_[lower], point);
  const double to_upper = distance2(boxes_[upper], point);
  const bool lower_first = to_lower <= to_upper;
  if (lower_first && to_lower <= best.distance2) search(lower, first, half, point, best);
  if (to_upper <= best.distance2) search(upper, half, last, point, best);
  if (!lower_first && to_lower <= best.distance2) search(lower, first, half, point, best);
}

int64_t NearestVoxel::find(const Vec3& point) const {
  // farther out, distances differ by less than their rounding
  constexpr double kFar = 4 * kLatticeLimit;
  Vec3 near;
  for (int d = 0; d < 3; ++d) near[d] = std::clamp(point[d], -kFar, kFar);
  Best best = {std::numeric_limits<double>::infinity(), -1};
  if (!boxes_.empty()) search(0, 0, static_cast<int64_t>(bricks_.size()), near, best);
  return best.voxel;
}

}  // namespace elastogen
