// SPDX-License-Identifier: Apache-2.0
// What contact on the device keeps for steps of stages (friction.cu).

#pragma once

#include "core/cuda/groups.cuh"
#include "core/point_contact.hpp"
#include "core/scene.hpp"

namespace elastogen::cuda {

struct ContactBonds {
  using Action = Sums<12>;  ///< force, torque, normal, power, rubbed, driven, energy, bond

  explicit ContactBonds(const Scene& scene);

  DeviceArray<Vec3> held, slip;       // kept and in the present step [m], (obstacles, points)
  DeviceArray<ContactLag> last_lags;  // before renew_lag()
  DeviceArray<SumScratch<Sums<1>>> sums;
  double end_time = 0, per_dt = 0;  // of the present step [s], [1/s]
  DeviceGroups pieces;              // points of each piece
  DeviceArray<Vec3> about;          // points of torques [m], (pieces)
  DeviceArray<Action> parts;        // of the chunks
  PinnedArray<Action> actions;      // (pieces)
};

}  // namespace elastogen::cuda
