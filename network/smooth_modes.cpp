// SPDX-License-Identifier: Apache-2.0
#include "network/smooth_modes.hpp"

#include <algorithm>
#include <cmath>
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

double cosine(const Wave& wave, const Box& box, const double X[3]) {
  double value = 1;
  for (int d = 0; d < 3; ++d)
    if (wave[size_t(d)] > 0)
      value *= std::cos(std::numbers::pi * wave[size_t(d)] * (X[d] - box.lower[size_t(d)]) /
                        box.extent(d));
  return value;
}

std::vector<double> pin_distance(const Scene& scene, const std::vector<int32_t>& nodes) {
  const VoxelGrid& grid = scene.grid;
  std::vector<int32_t> place(size_t(grid.node_count()), -1), seed(nodes.size(), -1);
  std::vector<double> distance(nodes.size(), 1e300);
  std::vector<int32_t> queue, next;
  for (size_t k = 0; k < nodes.size(); ++k) {
    place[size_t(nodes[k])] = int32_t(k);
    if (!scene.pinned(nodes[k])) continue;
    seed[k] = nodes[k];
    distance[k] = 0;
    queue.push_back(int32_t(k));
  }
  const auto between = [&](int32_t a, int32_t b) {
    const double* p = grid.rest.row(a);
    const double* q = grid.rest.row(b);
    return std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
  };
  while (!queue.empty()) {
    next.clear();
    for (const int32_t from : queue)
      for (int c = 0; c < 8; ++c) {
        const int32_t v = grid.voxels(nodes[size_t(from)], c);
        if (v < 0) continue;
        for (int e = 0; e < 8; ++e) {
          const int32_t to = place[size_t(grid.corners(v, e))];
          const double d = between(seed[size_t(from)], grid.corners(v, e));
          if (d >= distance[size_t(to)] * (1 - 1e-12)) continue;
          distance[size_t(to)] = d;
          seed[size_t(to)] = seed[size_t(from)];
          next.push_back(to);
        }
      }
    queue.swap(next);
  }
  return distance;
}

}  // namespace elastogen
