// SPDX-License-Identifier: Apache-2.0
// The data of DeviceContact, for its sources: contact.cu (energy, force, stiffness), carry.cu (where
// steps start and end) and friction.cu (steps of stages).

#pragma once

#include "network/contact/bonds.cuh"
#include "network/contact/contact.hpp"
#include "network/contact/contact_device.hpp"
#include "network/contact/contact_view.cuh"

#include <optional>

namespace elastogen::cuda {

/// For each of some surface nodes: its points and their weights.
struct GatherView {
  const int32_t *nodes, *begin, *point;  ///< (count), (count + 1), (entries)
  const double* weight;                  ///< (entries)
  int64_t count;
};

/// Owns them.
struct GatherLists {
  GatherView view() const {
    return {nodes.data(), begin.data(), point.data(), weight.data(), nodes.size()};
  }
  DeviceArray<int32_t> nodes, begin, point;
  DeviceArray<double> weight;
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
  double rubbing = 0;  ///< points and colliders with friction in a stage
};

struct DeviceContact::Impl {
  explicit Impl(const PotentialTerms& host);

  ContactView view() {
    return {corners.data(),
            weights.data(),
            position.data(),
            stiffness.data(),
            obstacles.data(),
            lags.data(),
            start.data(),
            stiffness.size(),
            int(obstacles.size()),
            lengths,
            bonds ? bonds->slip.data() : nullptr};
  }
  GatherLists list_entries(bool of_pinned, std::vector<int32_t>& listed) const;
  void place_obstacles(double time, double dt, double lag_time);
  void take_lags(const double* u);
  void set_lags(const double* u);
  void sum_actions(const double* u, const double* start, const double* stage);
  void sweep(const double* u, const double* end);
  bool crowds(int obstacle, const double* u, double motion);
  void carry(double* u);
  void carry_along(int obstacle, const Vec3& swept, double motion, double* u);
  template <class T>
  void gather_forces(const GatherLists& lists, T* to) const;

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
  GatherLists at_free;           // nodes that do not keep their position
  GatherLists at_pinned;         // those that do, in a scene with holders
  DeviceArray<double> frozen;    // symmetric, (points, 6)
  DeviceArray<double> blocks;    // of nodal_stiffness
  DeviceArray<int32_t> touched;  // 1: forces are not all 0
  DeviceArray<double> rest;      // of the nodes; like the next two for moving colliders only
  DeviceArray<uint8_t> pinned, carried;
  DeviceArray<SumScratch<ContactSums>> energy_sums;
  DeviceArray<SumScratch<Sweep>> sweep_sums;
  DeviceArray<SumScratch<Sums<1>>> crowd_sums;
  DeviceArray<Sweep> swept;
  std::optional<ContactBonds> bonds;  // of a scene whose steps have stages
  PinnedArray<ContactNumbers> numbers;
};

}  // namespace elastogen::cuda
