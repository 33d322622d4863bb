// SPDX-License-Identifier: Apache-2.0
// What the kernels of a step read and leave (device_step.cuh).

#pragma once

#include "core/node_loads.hpp"
#include "network/step/step_work.hpp"

namespace elastogen::cuda {

/// The arrays of the state and of the scene that a step reads.
struct Motion {
  const double *x, *v, *x_before, *v_before;  ///< those before are those now in an Euler step
  const double *rest, *mass, *load;           ///< no load: null
  const uint8_t* pinned;
  StepScheme scheme;
  double gravity[3];

  /// elastogen::pull of number k = 3 node + component.
  __device__ double pull(int64_t k) const {
    return load == nullptr ? gravity[k % 3] : gravity[k % 3] + load[k] / mass[k / 3];
  }
};

/// Loads that change, which the host makes (device_loads.cu).
struct HostLoads {
  explicit HostLoads(const Scene& scene) : now(scene) {}
  NodeLoads now;
  Array<double> first;  ///< at the end of SDIRK2's first stage
  Array<double> x, v;   ///< where the wind is found
};

/// The largest of what it is given.
struct Largest {
  double value = 0;
  __device__ void add(const Largest& o) { value = o.value > value ? o.value : value; }
};

/// Numbers that kernels leave for the host.
struct StepNumbers {
  double farthest, reach, square, not_finite;
  MotionEnergy energy;
};

}  // namespace elastogen::cuda
