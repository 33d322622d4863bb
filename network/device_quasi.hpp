// SPDX-License-Identifier: Apache-2.0
// The quasi mode on the device: the iteration of quasi_solver.hpp with all vectors in its memory.
// The host decides, on a few numbers an iteration.

#pragma once

#include "network/device.hpp"
#include "network/device_potential.hpp"

namespace elastogen::cuda {

class DeviceQuasi : public DeviceIterations {
 public:
  /// As make_device_iterations.
  DeviceQuasi(const IncrementalPotential& potential, const Preconditioner<float>& first);
  ~DeviceQuasi() override;

  void begin_step() override;
  void set_nodal_rotations(const double* u) override;
  IterationResult solve(double* u, double target, int max_outer, bool float64,
                        const std::function<bool()>& interrupted) override;
  PotentialValue value(const double* u) override;
  PotentialValue residual(const double* u, double& size) override;
  void download_gradient(double* gradient) const override;

  DevicePotential& potential();
  /// z = B r, both (nodes, 3) on the device; for tests and benchmarks. T float or double.
  template <class T>
  void precondition(const T* r, T* z);

  struct Impl;

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace elastogen::cuda
