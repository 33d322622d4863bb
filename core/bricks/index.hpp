// SPDX-License-Identifier: Apache-2.0
// Lattice points in 8x8x8 bricks: their order, and the number of a point in that order.

#pragma once

#include "core/array.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace elastogen {

using Coord = std::array<int32_t, 3>;

/// Coordinates of voxels and nodes lie in [-kLatticeLimit, kLatticeLimit).
inline constexpr int32_t kLatticeLimit = 1 << 20;

/// Sort key of a lattice point: Morton code of its brick, then the place inside, x fastest.
uint64_t brick_key(const Coord& point);

/// A sorted set of lattice points, stored as one bit mask for each brick.
class BrickIndex {
 public:
  BrickIndex() = default;
  /// @param keys  sorted keys of the bricks (brick_key >> 9), all different.
  explicit BrickIndex(std::vector<uint64_t> keys);
  /// The points in the rows of coords, in any order, duplicates allowed; fastest if bricks are in
  /// order.
  explicit BrickIndex(In<int32_t> coords);

  void insert(int64_t brick, int place) { bricks_[brick].mask[place >> 6] |= bit(place); }
  /// Numbers the points; to be called after the last insert. @return their count.
  int64_t number();

  int64_t brick_count() const { return static_cast<int64_t>(keys_.size()); }
  /// Number of a brick, -1 if it is not there.
  int64_t find_brick(uint64_t key) const;
  /// Number of a point of a brick, -1 if it is not there.
  int64_t find(int64_t brick, int place) const;
  int64_t find(const Coord& point) const;
  int64_t point_count() const { return points_; }
  /// Bits of the points of a brick, a word for each plane of z, x + 8 y; and its first point's
  /// number.
  const std::array<uint64_t, 8>& mask(int64_t brick) const { return bricks_[brick].mask; }
  int64_t first(int64_t brick) const { return bricks_[brick].first; }
  /// Coordinates of the first place of a brick.
  Coord first_place(int64_t brick) const;
  /// Coordinates of all points in order, (points, 3).
  Array<int32_t> points() const;

  /// The points of half the coordinates, rounded down, each once.
  BrickIndex halved() const;
  /// All corners of the points as voxels: these and those 1 further along some axes. Numbered.
  BrickIndex corners() const;

 private:
  struct Brick {
    std::array<uint64_t, 8> mask = {};   ///< a word for each plane of z, x + 8 y
    int64_t first = 0;                   ///< number of its first point
    std::array<int16_t, 8> before = {};  ///< its points in the planes before each
  };
  static uint64_t bit(int place) { return uint64_t{1} << (place & 63); }
  Brick brick_at(const Coord& point) const;
  void drop_empty_bricks();

  std::vector<uint64_t> keys_;
  std::vector<Brick> bricks_;
  int64_t points_ = 0;
};

}  // namespace elastogen
