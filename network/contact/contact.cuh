// SPDX-License-Identifier: Apache-2.0
// The data of DeviceContact, for its two sources: contact.cu (energy, force, stiffness) and
// carry.cu (where steps start and end).

#pragma once

#include "core/cuda/reduce.cuh"
#include "network/contact/contact.hpp"
#include "network/contact/contact_device.hpp"

namespace elastogen::cuda {

/// A collider's core and its path through the step.
struct DeviceObstacle : ObstaclePath {
  ColliderForm core;
  double friction = 0;
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

  __device__ Vec3 place(int64_t p, const double* u) const {
    Vec3 sum = {};
    for (int c = 0; c < 8; ++c) {
      const double w = weights[8 * p + c];
      const double* of = u + 3 * int64_t(corners[8 * p + c]);
      for (int i = 0; i < 3; ++i) sum[i] += w * of[i];
    }
    for (int i = 0; i < 3; ++i) sum[i] += position[3 * p + i];
    return sum;
  }
  __device__ const ContactLag& lag(int obstacle, int64_t p) const {
    return lags[obstacle * points + p];
  }
  __device__ ContactPoint point(int64_t p, const double* u) const {
    return {place(p, u), start[p], stiffness[p]};
  }
};

/// For each surface node that is not pinned: its points and their weights.
struct GatherView {
  const int32_t *nodes, *begin, *point;  ///< (count), (count + 1), (entries)
  const double* weight;                  ///< (entries)
  int64_t count;
};

/// Energy and deepest overlap.
struct ContactSums {
  double energy = 0, deepest = 0;
  __device__ void add(const ContactSums& o) {
    energy += o.energy;
    deepest = o.deepest > deepest ? o.deepest : deepest;
  }
};

/// The largest share of a path that all points allow, and the first collider whose core contains a
/// point at its start (1e300: none).
struct Sweep {
  double share = 1, inside = 1e300;
  __device__ void add(const Sweep& o) {
    share = o.share < share ? o.share : share;
    inside = o.inside < inside ? o.inside : inside;
  }
};

/// Numbers that the host reads.
struct ContactNumbers {
  ContactSums sums;
  Sweep swept;
  double crowded = 0;  ///< points that a collider crowds
};

struct DeviceContact::Impl {
  explicit Impl(const PotentialTerms& host);

  ContactView view() {
    return {corners.data(),        weights.data(), position.data(), stiffness.data(),
            obstacles.data(),      lags.data(),    start.data(),    stiffness.size(),
            int(obstacles.size()), lengths};
  }
  GatherView gather() const {
    return {nodes.data(), begin.data(), point.data(), weight.data(), nodes.size()};
  }
  void list_entries();
  void place_obstacles(double time);
  void take_lags(const double* u);
  void sweep(const double* u, const double* end);
  bool crowds(int obstacle, const double* u, double motion);
  void carry(double* u);
  void carry_along(int obstacle, const Vec3& swept, double motion, double* u);
  template <class T>
  void gather_forces(T* to) const;

  const Scene& scene;
  ContactLengths lengths;
  std::vector<Collider> cores;
  std::vector<DeviceObstacle> host_obstacles;
  std::vector<int32_t> surface_nodes;
  bool moving = false;  // some collider has a path
  bool stiff = false;

  DeviceArray<int32_t> corners;
  DeviceArray<double> weights, position, stiffness;
  DeviceArray<DeviceObstacle> obstacles;
  DeviceArray<ContactLag> lags;
  DeviceArray<Vec3> start, force;
  DeviceArray<int32_t> nodes, begin, point;
  DeviceArray<double> weight;
  DeviceArray<double> frozen;    // symmetric, (points, 6)
  DeviceArray<double> blocks;    // of nodal_stiffness
  DeviceArray<int32_t> touched;  // 1: forces are not all 0
  DeviceArray<double> rest;      // of the nodes; like the next two for moving colliders only
  DeviceArray<uint8_t> pinned, carried;
  DeviceArray<SumScratch<ContactSums>> energy_sums;
  DeviceArray<SumScratch<Sweep>> sweep_sums;
  DeviceArray<SumScratch<Sums<1>>> crowd_sums;
  DeviceArray<Sweep> swept;
  PinnedArray<ContactNumbers> numbers;
};

}  // namespace elastogen::cuda
