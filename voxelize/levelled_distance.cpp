// SPDX-License-Identifier: Apache-2.0
#include "voxelize/levelled_distance.hpp"

#include "core/vec3.hpp"

#include <cmath>
#include <map>

namespace elastogen {
namespace {

constexpr int kPoints = 12;  // sample points along an edge of a voxel

struct WeightedSum {
  double weight = 0, sum = 0;
  void add(double value, double w) { weight += w, sum += w * value; }
};

using NodeMeans = std::map<int32_t, WeightedSum>;

Vec3 rest_of(const VoxelGrid& grid, int32_t node) {
  return {grid.rest(node, 0), grid.rest(node, 1), grid.rest(node, 2)};
}

/// Mean over the border within a voxel of the interpolant of the distance, weighted with the number of
/// sample points: those of a lattice within half a spacing from the border, moved onto it.
WeightedSum mean_on_border(const VoxelGrid& grid, const Border& border, int32_t voxel) {
  double d[8];
  const int32_t* corners = grid.corners.row(voxel);
  for (int c = 0; c < 8; ++c) d[c] = distance(border, rest_of(grid, corners[c]));
  const Vec3 origin = rest_of(grid, corners[0]);
  const double band = grid.h / kPoints;
  // the points near the border, moved onto it
  WeightedSum mean;
  for (int k = 0; k < kPoints * kPoints * kPoints; ++k) {
    const int at[3] = {k % kPoints, k / kPoints % kPoints, k / kPoints / kPoints};
    Vec3 x;
    for (size_t i = 0; i < 3; ++i) x[i] = origin[i] + grid.h * (at[i] + 0.5) / kPoints;
    const double away = distance(border, x);
    if (std::abs(away) > band) continue;
    x = minus(x, scaled(distance_gradient(border, x), away));
    double value = 0;
    for (int c = 0; c < 8; ++c) {
      double N = 1;
      for (size_t i = 0; i < 3; ++i) {
        const double t = (x[i] - origin[i]) / grid.h;
        N *= c >> i & 1 ? t : 1 - t;
      }
      value += N * d[c];
    }
    mean.add(value, 1);
  }
  return mean;
}

/// Gives the nodes around those of a ring the mean of e over their neighbours in it.
void spread_excess(const VoxelGrid& grid, NodeMeans& ring,
                   std::unordered_map<int32_t, double>& excess) {
  NodeMeans next;
  for (const auto& [node, mean] : ring)
    for (int k = 0; k < 8; ++k) {
      const int32_t v = grid.voxels(node, k);
      if (v < 0) continue;
      for (int c = 0; c < 8; ++c)
        if (const int32_t n = grid.corners(v, c); !excess.contains(n))
          next[n].add(excess.at(node), 1);
    }
  for (const auto& [node, mean] : next) excess[node] = mean.sum / mean.weight;
  ring = std::move(next);
}

}  // namespace

LevelledDistance::LevelledDistance(const VoxelGrid& grid, const Border& border,
                                   const std::vector<int32_t>& voxels)
    : grid_(grid), border_(border) {
  if (border.is_plane) return;
  NodeMeans ring;
  for (const int32_t v : voxels) {
    const WeightedSum mean = mean_on_border(grid, border, v);
    if (mean.weight == 0) continue;
    for (int c = 0; c < 8; ++c) ring[grid.corners(v, c)].add(mean.sum / mean.weight, mean.weight);
  }
  for (const auto& [node, mean] : ring) excess_[node] = mean.sum / mean.weight;
  for (int rings = 0; rings < 2; ++rings) spread_excess(grid, ring, excess_);
}

double LevelledDistance::operator()(int32_t node) const {
  const double d = distance(border_, rest_of(grid_, node));
  const auto e = excess_.find(node);
  return e == excess_.end() ? d : d - e->second;
}

}  // namespace elastogen
