// SPDX-License-Identifier: Apache-2.0
// The points of a surface and the colliders on the device, as kernels read them.

#pragma once

#include "core/point_contact.hpp"
#include "network/contact/contact_device.hpp"

namespace elastogen::cuda {

/// A collider's core and its path through the step.
struct DeviceObstacle : ObstaclePath {
  ColliderForm core;
  double friction = 0;
  Vec3 lag = {};  ///< its place at the time of a stage's lag [m]
};

/// The points of the surface and the colliders, as kernels read them.
struct ContactView {
  const int32_t* corners;                        ///< (points, 8)
  const double *weights, *position, *stiffness;  ///< (points, 8), (points, 3), (points)
  const DeviceObstacle* obstacles;
  ContactLag* lags;  ///< (obstacles, points)
  Vec3* start;       ///< (points)
  int64_t points;
  int obstacle_count;
  ContactLengths lengths;
  Vec3* slip;  ///< of the bonds of a stage, (obstacles, points), else null

  /// Value at a point of a field of the nodes.
  __device__ Vec3 carried(int64_t p, const double* u) const {
    Vec3 sum = {};
    for (int c = 0; c < 8; ++c) {
      const double w = weights[8 * p + c];
      const double* of = u + 3 * int64_t(corners[8 * p + c]);
      for (int i = 0; i < 3; ++i) sum[i] += w * of[i];
    }
    return sum;
  }
  __device__ Vec3 place(int64_t p, const double* u) const {
    Vec3 sum = carried(p, u);
    for (int i = 0; i < 3; ++i) sum[i] += position[3 * p + i];
    return sum;
  }
  __device__ const ContactLag& lag(int obstacle, int64_t p) const {
    return lags[obstacle * points + p];
  }
  __device__ ContactPoint point(int64_t p, const double* u) const {
    return {place(p, u), start[p], stiffness[p]};
  }
  /// A point at an obstacle; the slip of its bond counts as slip of the step.
  __device__ ContactPoint bonded(ContactPoint point, int obstacle, int64_t p) const {
    if (slip != nullptr) point.start = minus(point.start, slip[obstacle * points + p]);
    return point;
  }
};

/// The frozen stiffness of contact between nodes.
struct FrozenStiffness {
  const int32_t *nodes, *begin, *point;  ///< surface nodes, ascending, and the points of each
  const double* weight;                  ///< of these points at the node
  int64_t count;                         ///< of the nodes; 0: there is no stiffness
  const int32_t* corners;                ///< (points, 8)
  const double *weights, *blocks;        ///< (points, 8); symmetric, (points, 6)

  /// Adds the block of two nodes [N/m].
  __device__ void add(int32_t row, int32_t column, float block[9]) const {
    // the surface node
    int64_t low = 0, high = count;
    while (low < high) {
      const int64_t middle = (low + high) / 2;
      if (nodes[middle] < row)
        low = middle + 1;
      else
        high = middle;
    }
    if (low == count || nodes[low] != row) return;
    // its points that the other node carries too
    for (int32_t k = begin[low]; k < begin[low + 1]; ++k)
      for (int c = 0; c < 8; ++c) {
        const int64_t p = point[k];
        if (corners[8 * p + c] != column) continue;
        const double w = weight[k] * weights[8 * p + c];
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j)
            block[3 * i + j] += float(w * blocks[6 * p + symmetric_place(i, j)]);
      }
  }
};

}  // namespace elastogen::cuda
