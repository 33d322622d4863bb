// SPDX-License-Identifier: Apache-2.0
#include "network/smooth_modes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace elastogen {

std::vector<Wave> lowest_waves(const Box& box, int count) {
  std::vector<std::pair<double, Wave>> waves;
  const auto frequency = [&](int k, int d) {
    const double length = box.extent(d);
    if (k == 0) return 0.0;
    return length > 0 ? k * k / (length * length) : 1e300;
  };
  for (int x = 0; x < count; ++x)
    for (int y = 0; y < count; ++y)
      for (int z = 0; z < count; ++z)
        if ((x + 1) * (y + 1) * (z + 1) <= count)  // no other can be among the lowest
          waves.push_back({frequency(x, 0) + frequency(y, 1) + frequency(z, 2), {x, y, z}});
  std::sort(waves.begin(), waves.end());
  std::vector<Wave> result;
  for (int k = 0; k < count; ++k) result.push_back(waves[size_t(k)].second);
  return result;
}

PlaneCosines::PlaneCosines(const VoxelGrid& grid, const std::vector<int32_t>& nodes,
                           std::vector<Wave> waves, const Box& box)
    : waves_(std::move(waves)) {
  for (int d = 0; d < 3; ++d) {
    int32_t last = first_[d] = nodes.empty() ? 0 : grid.node_coord(nodes[0], d);
    for (const int32_t n : nodes) {
      first_[d] = std::min(first_[d], grid.node_coord(n, d));
      last = std::max(last, grid.node_coord(n, d));
    }
    for (int32_t plane = first_[d]; plane <= last; ++plane)
      for (const Wave& wave : waves_) {
        const double share =
            wave[size_t(d)] > 0 ? double(plane - first_[d]) * grid.h / box.extent(d) : 0;
        table_[d].push_back(std::cos(std::numbers::pi * wave[size_t(d)] * share));
      }
  }
}

namespace {

/// The bit of corner e of the voxel whose corner c a node is, among the 27 nodes around that.
constexpr auto kAround = [] {
  std::array<std::array<int, 8>, 8> bit = {};
  for (size_t c = 0; c < 8; ++c)
    for (size_t e = 0; e < 8; ++e) {
      size_t place = 0, step = 1;
      for (int d = 0; d < 3; ++d, step *= 3) place += step * (1 + (e >> d & 1) - (c >> d & 1));
      bit[c][e] = 1 << place;
    }
  return bit;
}();

/// A node with the nearest pin that is known to it, in lattice coordinates.
struct Reached {
  std::array<int32_t, 3> at, pin;
  int64_t square;  ///< of their distance, in edges
};

int64_t square_between(const std::array<int32_t, 3>& a, const std::array<int32_t, 3>& b) {
  int64_t sum = 0;
  for (size_t d = 0; d < 3; ++d) sum += int64_t(a[d] - b[d]) * (a[d] - b[d]);
  return sum;
}

}  // namespace

std::vector<double> pin_distance(const Scene& scene, const std::vector<int32_t>& nodes) {
  constexpr int64_t kNone = std::numeric_limits<int64_t>::max();
  const VoxelGrid& grid = scene.grid;
  std::vector<int32_t> place(size_t(grid.node_count()), -1), queue, next;
  std::vector<Reached> reached(nodes.size());
  for (size_t k = 0; k < nodes.size(); ++k) {
    place[size_t(nodes[k])] = int32_t(k);
    Reached& node = reached[k];
    std::copy_n(grid.node_coord.row(nodes[k]), 3, node.at.begin());
    node.pin = node.at;
    node.square = scene.pinned(nodes[k]) ? 0 : kNone;
    if (node.square == 0) queue.push_back(int32_t(k));
  }
  while (!queue.empty()) {
    next.clear();
    for (const int32_t from : queue) {
      const std::array<int32_t, 3> pin = reached[size_t(from)].pin;
      for (int c = 0, seen = 0; c < 8; ++c) {
        const int32_t v = grid.voxels(nodes[size_t(from)], c);
        if (v < 0) continue;
        for (int e = 0; e < 8; ++e) {
          // voxels share most of the 26 nodes around
          const int side = kAround[size_t(c)][size_t(e)];
          if (seen & side) continue;
          seen |= side;
          const int32_t to = place[size_t(grid.corners(v, e))];
          Reached& node = reached[size_t(to)];
          const int64_t square = square_between(pin, node.at);
          if (square >= node.square) continue;
          node.square = square;
          node.pin = pin;
          next.push_back(to);
        }
      }
    }
    queue.swap(next);
  }
  std::vector<double> distance(nodes.size(), 1e300);
  for (size_t k = 0; k < nodes.size(); ++k)
    if (reached[k].square != kNone) distance[k] = grid.h * std::sqrt(double(reached[k].square));
  return distance;
}

}  // namespace elastogen
