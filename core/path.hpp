// SPDX-License-Identifier: Apache-2.0
// Offsets that are scripted in time, of colliders and of parts that are moved.

#pragma once

#include "core/base.hpp"

#include <initializer_list>
#include <vector>

namespace elastogen {

struct PathKey {
  double time = 0;   ///< [s], ascending
  Vec3 offset = {};  ///< [m], or a rotation vector of a turn [rad]
};

/// Straight between keys, at rest before the first and after the last; empty: no offset.
struct Path {
  Path() = default;
  Path(std::vector<PathKey> k) : keys(std::move(k)) {}
  Path(std::initializer_list<PathKey> k) : keys(k) {}

  bool moves() const { return keys.size() > 1; }

  std::vector<PathKey> keys;
  bool eases = false;  ///< it comes to rest at each key: 3 s^2 - 2 s^3 of the way in place of s
  bool loops = false;  ///< after the last key it begins anew at the first
};

Vec3 offset_at(const Path& path, double time);
/// Its rate just before a time [1/s].
Vec3 rate_at(const Path& path, double time);
/// What changes that rate there [1/s^2]; jumps of the rate at keys are not in it.
Vec3 acceleration_at(const Path& path, double time);
/// The first time after `time` at which a key stands [s]; infinite if there is none.
double next_key(const Path& path, double time);

/// @throws Error unless keys are finite, times ascend and a path that loops takes some time.
void check_path(const Path& path);

}  // namespace elastogen
