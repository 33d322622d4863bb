// SPDX-License-Identifier: Apache-2.0
// The newton mode on the device: the iteration of newton_solver.hpp on what DeviceQuasi holds, its
// potential, preconditioner and displacement. The host decides, on a few numbers an iteration.

#pragma once

#include "network/device_quasi.hpp"

namespace elastogen::cuda {

class DeviceNewton {
 public:
  /// @throws Error (resources) where the device has no room.
  explicit DeviceNewton(DeviceQuasi& quasi);
  ~DeviceNewton();

  /// As NewtonSolver::solve on the displacement that the device works on.
  IterationResult solve(double target, int max_outer, int max_inner,
                        const std::function<bool()>& interrupted);

  /// What it takes of the device's memory, with the tangents of the potential.
  static size_t bytes(const DevicePotential& potential);

  struct Impl;

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace elastogen::cuda
