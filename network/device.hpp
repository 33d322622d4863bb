// SPDX-License-Identifier: Apache-2.0
// What the solver knows of the CUDA device, in builds with and without it.

#pragma once

#include "network/quasi_solver.hpp"

#include <memory>
#include <string>

namespace elastogen::cuda {

/// Whether there is a device to run on; false in builds without CUDA.
bool has_device();

/// Name of the device.
std::string device_name();

/// The quasi mode with all that it iterates on in the device's memory. Arrays are the host's.
class DeviceIterations {
 public:
  virtual ~DeviceIterations() = default;

  /// Takes the step that the host's potential has begun.
  virtual void begin_step() = 0;
  /// Nodal rotations of the preconditioner from the start value of the iteration, (nodes, 3).
  virtual void set_nodal_rotations(const double* u) = 0;
  /// As QuasiSolver<T>::solve with a first matrix in float; T is double with float64, else float.
  virtual IterationResult solve(double* u, double target, int max_outer, bool float64,
                                const std::function<bool()>& interrupted) = 0;
  /// Value of the potential in float64.
  virtual PotentialValue value(const double* u) = 0;
  /// IncrementalPotential::residual; the gradient stays on the device until it is asked for.
  /// @param size  gets |gradient|_2.
  virtual PotentialValue residual(const double* u, double& size) = 0;
  /// The gradient of the last call of residual, (nodes, 3).
  virtual void download_gradient(double* gradient) const = 0;
};

/// On the tables of both, which must outlive it.
/// @throws Error (usage) for colliders and nets without a table, (resources) where the device has
///         no room, (device) in builds without CUDA.
std::unique_ptr<DeviceIterations> make_device_iterations(const IncrementalPotential& potential,
                                                         const Preconditioner<float>& first);

}  // namespace elastogen::cuda
