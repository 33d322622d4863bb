// SPDX-License-Identifier: Apache-2.0
#include "voxelize/brick_index.hpp"

#include "core/parallel.hpp"
#include "core/parallel_sort.hpp"

#include <algorithm>
#include <bit>

namespace elastogen {
namespace {

constexpr int64_t kBricks = 8;  // of one task

/// Puts two zero bits between the lowest 18 bits.
uint64_t spread(uint64_t x) {
  x = (x | x << 32) & 0x001f00000000ffff;
  x = (x | x << 16) & 0x001f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  return (x | x << 2) & 0x1249249249249249;
}

/// The inverse of spread.
uint64_t gather(uint64_t x) {
  x &= 0x1249249249249249;
  x = (x ^ x >> 2) & 0x10c30c30c30c30c3;
  x = (x ^ x >> 4) & 0x100f00f00f00f00f;
  x = (x ^ x >> 8) & 0x001f0000ff0000ff;
  x = (x ^ x >> 16) & 0x001f00000000ffff;
  return (x ^ x >> 32) & 0x00000000001fffff;
}

}  // namespace

uint64_t brick_key(const Coord& point) {
  uint64_t brick = 0, place = 0;
  for (int d = 0; d < 3; ++d) {
    const auto shifted = static_cast<uint64_t>(point[d] + kLatticeLimit);
    brick |= spread(shifted >> 3) << d;
    place |= (shifted & 7) << (3 * d);
  }
  return brick << 9 | place;
}

BrickIndex::BrickIndex(std::vector<uint64_t> keys)
    : keys_(std::move(keys)), bricks_(keys_.size()) {}

BrickIndex::BrickIndex(In<int32_t> coords) {
  std::vector<uint64_t> keys(coords.rows);
  for_each(coords.rows, [&](int64_t v) {
    keys[v] = brick_key({coords(v, 0), coords(v, 1), coords(v, 2)});
  });
  parallel_sort(keys.begin(), keys.end());
  for (const uint64_t key : keys) {
    if (keys_.empty() || keys_.back() != key >> 9) {
      keys_.push_back(key >> 9);
      bricks_.emplace_back();
    }
    insert(brick_count() - 1, static_cast<int>(key & 511));
  }
  number();
}

int64_t BrickIndex::number() {
  points_ = 0;
  for (Brick& brick : bricks_) {
    brick.first = points_;
    for (const uint64_t word : brick.mask) points_ += std::popcount(word);
  }
  return points_;
}

int64_t BrickIndex::find_brick(uint64_t key) const {
  const auto place = std::lower_bound(keys_.begin(), keys_.end(), key);
  return place != keys_.end() && *place == key ? place - keys_.begin() : -1;
}

int64_t BrickIndex::find(int64_t brick, int place) const {
  const Brick& b = bricks_[brick];
  if (!(b.mask[place >> 6] & bit(place))) return -1;
  int64_t rank = b.first + std::popcount(b.mask[place >> 6] & (bit(place) - 1));
  for (int word = 0; word < place >> 6; ++word) rank += std::popcount(b.mask[word]);
  return rank;
}

int64_t BrickIndex::find(const Coord& point) const {
  for (const int32_t x : point)
    if (x < -kLatticeLimit || x >= kLatticeLimit) return -1;
  const uint64_t key = brick_key(point);
  const int64_t brick = find_brick(key >> 9);
  return brick < 0 ? -1 : find(brick, static_cast<int>(key & 511));
}

Array<int32_t> BrickIndex::points() const {
  Array<int32_t> result(points_, 3);
  const auto write = [&](int64_t b) {
    Coord corner;
    for (int d = 0; d < 3; ++d)
      corner[d] = static_cast<int32_t>(gather(keys_[b] >> d) << 3) - kLatticeLimit;
    int32_t* row = result.row(bricks_[b].first);
    for (int word = 0; word < 8; ++word)
      for (uint64_t rest = bricks_[b].mask[word]; rest; rest &= rest - 1) {
        const int place = std::countr_zero(rest);
        *row++ = corner[0] + (place & 7);
        *row++ = corner[1] + (place >> 3);
        *row++ = corner[2] + word;
      }
  };
  for_each(brick_count(), write, kBricks);
  return result;
}

}  // namespace elastogen
