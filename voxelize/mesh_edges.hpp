// SPDX-License-Identifier: Apache-2.0
// Edges of welded triangles, and sets of triangles that record how their members are wound.

#pragma once

#include "core/array.hpp"
#include "core/bricks/index.hpp"

#include <numeric>
#include <tuple>
#include <vector>

namespace elastogen {

/// Two triangles that share an edge; turned if both run along it in the same direction.
struct Link {
  int32_t triangle[2];
  bool turned;
};

struct HalfEdge {
  int32_t lower, upper, triangle;
  bool forward;
  bool operator<(const HalfEdge& other) const {
    return std::tie(lower, upper, triangle) < std::tie(other.lower, other.upper, other.triangle);
  }
};

struct Edges {
  std::vector<Link> manifold;    ///< edges of two triangles
  std::vector<Link> branching;   ///< first and each further triangle of edges of three or more
  std::vector<HalfEdge> border;  ///< edges of one triangle
};

Edges find_edges(const std::vector<Coord>& triangles);

/// Union-find whose sets also record whether each member is turned relative to its root.
class OrientedSets {
 public:
  explicit OrientedSets(size_t n) : parent_(n), turned_(n, 0) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  int32_t root(int32_t n) {
    // two passes: find the root and the parity, then shorten the path
    int32_t top = n;
    uint8_t parity = 0;
    for (; parent_[top] != top; top = parent_[top]) parity ^= turned_[top];
    while (parent_[n] != n) {
      const int32_t next = parent_[n];
      const uint8_t rest = parity ^ turned_[n];
      parent_[n] = top;
      turned_[n] = parity;
      parity = rest;
      n = next;
    }
    return top;
  }
  bool turned(int32_t n) {
    root(n);
    return turned_[n];
  }
  /// @return false if the two are already in one set with the other parity.
  bool join(int32_t a, int32_t b, bool turned) {
    const int32_t ra = root(a), rb = root(b);
    const uint8_t parity = turned_[a] ^ turned_[b] ^ static_cast<uint8_t>(turned);
    if (ra == rb) return parity == 0;
    parent_[rb] = ra;
    turned_[rb] = parity;
    return true;
  }

 private:
  std::vector<int32_t> parent_;
  std::vector<uint8_t> turned_;
};

}  // namespace elastogen
