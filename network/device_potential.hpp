// SPDX-License-Identifier: Apache-2.0
// The incremental potential of a step on the device: energy and gradient by the maths of
// local_model.hpp, from tables that are uploaded once a scene. Colliders are left to the CPU.

#pragma once

#include "network/incremental_potential.hpp"

#include <memory>

namespace elastogen::cuda {

class DevicePotential {
 public:
  /// The host's potential must outlive it and have no colliders.
  /// @throws Error (usage) if it has, (resources) where the device has no room.
  explicit DevicePotential(const IncrementalPotential& host);
  ~DevicePotential();

  /// Takes predictor, inertia and the displacement at the start of the step from the host, and the
  /// frozen rotations from the latter; after the host's begin_step.
  void begin_step();

  /// Nodal rotations of the preconditioner from a displacement on the device, in float.
  void set_nodal_rotations(const double* u);

  /// Value, and gradient [N], (nodes, 3), 0 on pinned nodes; both arrays on the device.
  template <class T>
  PotentialValue evaluate(const double* u, T* gradient);
  /// The same in float64 with the smallest Jacobians, for the certificate.
  PotentialValue residual(const double* u, double* gradient);

  int64_t nodes() const;
  const uint8_t* pinned() const;        ///< (nodes), on the device
  const float* nodal_rotation() const;  ///< (nodes, 9), on the device
  const IncrementalPotential& host() const;

  struct Impl;

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace elastogen::cuda
