// SPDX-License-Identifier: Apache-2.0
#include "core/bricks/index.hpp"

#include "core/parallel.hpp"
#include "core/parallel_sort.hpp"

#include <algorithm>
#include <bit>
#include <functional>

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

namespace {

bool in_one_brick(const int32_t* a, const int32_t* b) {
  return a[0] >> 3 == b[0] >> 3 && a[1] >> 3 == b[1] >> 3 && a[2] >> 3 == b[2] >> 3;
}

int place_of(const int32_t* at) {
  return (at[0] & 7) | (at[1] & 7) << 3 | (at[2] & 7) << 6;
}

/// Sorted keys of all points.
Zeroed<uint64_t> sorted_keys(In<int32_t> coords) {
  Zeroed<uint64_t> keys(coords.rows);
  for_each(coords.rows, [&](int64_t v) {
    const int32_t* at = coords.row(v);
    keys[v] = brick_key({at[0], at[1], at[2]});
  });
  parallel_sort(keys.begin(), keys.end());
  return keys;
}

}  // namespace

BrickIndex::BrickIndex(In<int32_t> coords) {
  // most lists are in the order of the bricks
  std::vector<int32_t> first = filtered(coords.rows, [&](int64_t v) {
    return v == 0 || !in_one_brick(coords.row(v), coords.row(v - 1));
  });
  keys_.resize(first.size());
  for_each(
      brick_count(),
      [&](int64_t b) {
        const int32_t* at = coords.row(first[b]);
        keys_[b] = brick_key({at[0], at[1], at[2]}) >> 9;
      },
      kBricks);
  Zeroed<uint64_t> sorted;
  if (std::adjacent_find(keys_.begin(), keys_.end(), std::greater_equal<>()) != keys_.end()) {
    sorted = sorted_keys(coords);
    first = filtered(coords.rows,
                     [&](int64_t v) { return v == 0 || sorted[v] >> 9 != sorted[v - 1] >> 9; });
    keys_.clear();
    for (const int32_t v : first) keys_.push_back(sorted[v] >> 9);
  }
  bricks_.resize(keys_.size());
  first.push_back(static_cast<int32_t>(coords.rows));
  for_each(
      brick_count(),
      [&](int64_t b) {
        for (int32_t v = first[b]; v < first[b + 1]; ++v)
          insert(b, sorted.empty() ? place_of(coords.row(v)) : static_cast<int>(sorted[v] & 511));
      },
      kBricks);
  number();
}

int64_t BrickIndex::number() {
  points_ = 0;
  for (Brick& brick : bricks_) {
    brick.first = points_;
    for (int z = 0; z < 8; ++z) {
      brick.before[z] = static_cast<int16_t>(points_ - brick.first);
      points_ += std::popcount(brick.mask[z]);
    }
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
  return b.first + b.before[place >> 6] + std::popcount(b.mask[place >> 6] & (bit(place) - 1));
}

int64_t BrickIndex::find(const Coord& point) const {
  for (const int32_t x : point)
    if (x < -kLatticeLimit || x >= kLatticeLimit) return -1;
  const uint64_t key = brick_key(point);
  const int64_t brick = find_brick(key >> 9);
  return brick < 0 ? -1 : find(brick, static_cast<int>(key & 511));
}

Coord BrickIndex::first_place(int64_t brick) const {
  Coord corner;
  for (int d = 0; d < 3; ++d)
    corner[d] = static_cast<int32_t>(gather(keys_[brick] >> d) << 3) - kLatticeLimit;
  return corner;
}

Array<int32_t> BrickIndex::points() const {
  Array<int32_t> result(points_, 3);
  const auto write = [&](int64_t b) {
    const Coord corner = first_place(b);
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

namespace {

void sort_unique(std::vector<uint64_t>& keys) {
  parallel_sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
}

}  // namespace

/// The brick that holds a point, an empty one if there is none.
BrickIndex::Brick BrickIndex::brick_at(const Coord& point) const {
  const int64_t brick = find_brick(brick_key(point) >> 9);
  return brick < 0 ? Brick{} : bricks_[brick];
}

BrickIndex BrickIndex::halved() const {
  // bricks of half the coordinates
  std::vector<uint64_t> keys(keys_.size());
  for_each(
      brick_count(),
      [&](int64_t b) {
        Coord at = first_place(b);
        for (int32_t& x : at) x >>= 1;
        keys[b] = brick_key(at) >> 9;
      },
      kBricks);
  sort_unique(keys);
  BrickIndex result(std::move(keys));
  // their points, from the eight bricks that each of them covers
  const auto fill = [&](int64_t to) {
    constexpr uint64_t kEven = 0x0055005500550055;  // along x and y
    const Coord at = result.first_place(to);
    for (int c = 0; c < 8; ++c) {
      const Coord first = {2 * at[0] + 8 * (c & 1), 2 * at[1] + 8 * (c >> 1 & 1),
                           2 * at[2] + 8 * (c >> 2)};
      const Brick of = brick_at(first);
      for (int z = 0; z < 8; z += 2) {
        // one bit for each 2x2x2 points
        uint64_t word = of.mask[z] | of.mask[z + 1];
        word |= word >> 8;
        for (uint64_t rest = (word | word >> 1) & kEven; rest; rest &= rest - 1) {
          const int place = std::countr_zero(rest);
          result.insert(to, 4 * ((c & 1) + 8 * (c >> 1 & 1) + 64 * (c >> 2)) + (place & 7) / 2 +
                                place / 16 * 8 + z * 32);
        }
      }
    }
  };
  for_each(result.brick_count(), fill, kBricks);
  result.number();
  return result;
}

BrickIndex BrickIndex::corners() const {
  std::vector<uint64_t> keys(8 * keys_.size());
  for_each(
      brick_count(),
      [&](int64_t b) {
        for (int c = 0; c < 8; ++c) {
          Coord at = first_place(b);
          for (int d = 0; d < 3; ++d) at[d] += 8 * (c >> d & 1);
          const bool inside = *std::max_element(at.begin(), at.end()) < kLatticeLimit;
          keys[8 * b + c] = inside ? brick_key(at) >> 9 : keys_[b];
        }
      },
      kBricks);
  sort_unique(keys);
  BrickIndex result(std::move(keys));
  const auto fill = [&](int64_t b) {
    constexpr uint64_t kLowX = 0x0101010101010101;
    const Coord at = result.first_place(b);
    std::array<uint64_t, 8>& mask = result.bricks_[b].mask;
    for (int z = 0; z < 2; ++z)  // of the brick below, then this one
      for (int y = 0; y < 2; ++y) {
        const Coord before = {at[0] - 8, at[1] - 8 * (1 - y), at[2] - 8 * (1 - z)};
        const Brick low = brick_at(before), own = brick_at({at[0], before[1], before[2]});
        for (int plane = z == 0 ? 7 : 0; plane < 8; ++plane) {
          // along x, then y, then z
          uint64_t word = own.mask[plane] | (own.mask[plane] & ~(kLowX << 7)) << 1 |
                          (low.mask[plane] >> 7 & kLowX);
          word = y == 0 ? word >> 56 : word | word << 8;
          if (z == 1) mask[plane] |= word;
          if (z == 0 || plane < 7) mask[(plane + 1) & 7] |= word;
        }
      }
  };
  for_each(result.brick_count(), fill, kBricks);
  result.drop_empty_bricks();
  result.number();
  return result;
}

void BrickIndex::drop_empty_bricks() {
  size_t kept = 0;
  for (size_t b = 0; b < bricks_.size(); ++b) {
    const auto& mask = bricks_[b].mask;
    if (std::all_of(mask.begin(), mask.end(), [](uint64_t word) { return word == 0; })) continue;
    keys_[kept] = keys_[b];
    bricks_[kept++] = bricks_[b];
  }
  keys_.resize(kept);
  bricks_.resize(kept);
}

}  // namespace elastogen
