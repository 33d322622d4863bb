// SPDX-License-Identifier: Apache-2.0
// The newton mode (newton_loop.hpp) on the device, on the potential, preconditioner and
// displacement of a DeviceQuasi. The host decides, on a few numbers an iteration.

#pragma once

#include "network/step/quasi_solver_device.hpp"

namespace elastogen::cuda {

class DeviceNewton {
 public:
  /// @throws Error (resources) where the device has too little memory.
  explicit DeviceNewton(DeviceQuasi& quasi);
  ~DeviceNewton();

  /// newton_loop on the displacement of the DeviceQuasi.
  IterationResult solve(double target, int max_outer, int max_inner,
                        const Interrupted& interrupted);

  /// y = S y, S of time_error.hpp at the displacement of the DeviceQuasi, where the potential was
  /// evaluated last; (nodes, 3), on the device. Leaves the potential with the inertia of S.
  void filter(double interval, double* y);

  /// Bytes of the device's memory that it needs, with the tangents of the potential.
  static size_t bytes(const DevicePotential& potential);

  struct Impl;

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace elastogen::cuda
