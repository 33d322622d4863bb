// SPDX-License-Identifier: Apache-2.0
// Vertices as they are drawn: the positions of a mesh, split where attributes differ.

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace elastogen {

/// Gives each corner its drawn vertex (io/asset.hpp, Mesh). The first drawn vertices are the
/// positions in their order, each with the attributes of its first corner. Every further set of
/// attributes of a position adds one, in the order in which they come.
/// @tparam N  numbers of a corner: its position, then numbers that tell its attributes apart.
template <size_t N>
class DrawnVertices {
 public:
  using Corner = std::array<int32_t, N>;

  explicit DrawnVertices(size_t positions) : corner_(positions), drawn_(positions, 0) {
    for (size_t p = 0; p < positions; ++p) corner_[p][0] = int32_t(p);
  }

  /// The drawn vertex of a corner.
  int32_t operator()(const Corner& corner) {
    const auto position = size_t(corner[0]);
    if (!drawn_[position]) {
      drawn_[position] = 1;
      corner_[position] = corner;
    }
    if (corner_[position] == corner) return corner[0];
    const auto [entry, is_new] = split_.try_emplace(corner, int32_t(corner_.size()));
    if (is_new) corner_.push_back(corner);
    return entry->second;
  }

  size_t size() const { return corner_.size(); }

  int32_t position(size_t vertex) const { return corner_[vertex][0]; }

  /// A corner of the drawn vertex; null for a position without corners.
  const Corner* corner(size_t vertex) const {
    return vertex >= drawn_.size() || drawn_[vertex] ? &corner_[vertex] : nullptr;
  }

 private:
  struct Hash {
    size_t operator()(const Corner& corner) const {
      uint64_t h = 0;
      for (const int32_t i : corner) h = (h ^ uint32_t(i)) * 0x9e3779b97f4a7c15u, h ^= h >> 29;
      return h;
    }
  };

  std::vector<Corner> corner_;  ///< of each drawn vertex
  std::vector<uint8_t> drawn_;  ///< 1 for positions that have a corner
  std::unordered_map<Corner, int32_t, Hash> split_;
};

}  // namespace elastogen
