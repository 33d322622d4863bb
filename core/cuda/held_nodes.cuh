// SPDX-License-Identifier: Apache-2.0
// Where holders put nodes (core/held_nodes.hpp) on the device. The host finds the motions, which
// are copied; each number that is made of them has the bits of the host. Launches do not wait for
// the device; where no holder moves there are none but those of dependent nodes.

#pragma once

#include "core/cuda/dependent_nodes.cuh"
#include "core/cuda/groups.cuh"
#include "core/held_nodes.hpp"

namespace elastogen::cuda {

class DeviceHeldNodes {
 public:
  /// The scene must be finished and outlive it.
  /// @throws Error (resources) if the device has too little memory.
  explicit DeviceHeldNodes(const Scene& scene);

  /// As in HeldNodes; all arrays are (nodes, 3), on the device.
  bool move() const { return host_.move(); }
  /// Copies to the device, and waits for it, where a holder moves.
  void set_time(double time);
  void place_pinned(double* u) const;
  void follow(double* u) const;  ///< and fixed components
  void place(double* u) const { place_pinned(u), follow(u); }
  void set_velocities(const double* x, double* v) const;
  template <class T>
  void fill(T* values) const {
    fix(values);
    dependent_.fill(values);
  }
  template <class T>
  void fold(T* gradient) const {
    dependent_.fold(gradient);
    fix(gradient);
  }
  /// Sets fixed components to 0.
  template <class T>
  void fix(T* values) const;
  /// HeldNodes::fixed_axes of all nodes, null where no component is fixed.
  const uint8_t* fixed_axes() const { return axes_.data(); }
  const DeviceDependentNodes& dependent() const { return dependent_; }

  /// Whether a holder holds something.
  bool has_reactions() const { return groups_.count() > 0; }
  /// Starts the sums of HeldNodes::reactions, in an order that never changes; then r = 0 at pinned
  /// nodes.
  /// @param rest, load  of the scene; null: no load.
  void start_reactions(const double* rest, const double* load, const double* u, double* r);
  /// Those of the last start, when its kernels have ended.
  std::vector<Reaction> reactions() const;
  double power(const std::vector<Reaction>& reactions) const { return host_.power(reactions); }

 private:
  using DeviceSums = Sums<kHolderSums>;

  HeldNodes host_;
  Vec3 gravity_;
  DeviceDependentNodes dependent_;
  // fixed components
  DeviceArray<int32_t> fixed_;
  DeviceArray<uint8_t> axes_;
  // motion of pinned nodes, and what dependent ones have beside that from their parent nodes
  DeviceArray<int32_t> moved_, holders_of_moved_;
  DeviceArray<Vec3> place_, offset_;
  DeviceArray<HolderRate> rates_;
  // nodes of each holder, then pinned ones of none, as numbers in the list of all
  DeviceArray<HeldNode> nodes_;
  DeviceArray<Vec3> centres_;
  DeviceGroups groups_;
  DeviceArray<DeviceSums> parts_;  // of the chunks
  PinnedArray<DeviceSums> sums_;   // of the groups
};

}  // namespace elastogen::cuda
