// SPDX-License-Identifier: Apache-2.0
// The quasi mode (quasi_loop.hpp) on the device, with all vectors in its memory. The host decides,
// on a few numbers an iteration.

#pragma once

#include "network/potential/incremental_potential_device.hpp"
#include "network/precondition/preconditioner.hpp"
#include "network/step/iteration.hpp"

namespace elastogen::cuda {

template <class T>
class DeviceArray;

class DevicePreconditioner;

class DeviceQuasi {
 public:
  /// The terms must outlive it, and have the scheme that will be used.
  /// @throws Error (resources) where the device has too little memory.
  DeviceQuasi(const PotentialTerms& terms, const EncoderChoice& encoder);
  /// Without a first matrix there are no iterations: for the displacement and the potential.
  explicit DeviceQuasi(const PotentialTerms& terms);
  ~DeviceQuasi();

  /// Most bytes that steps of that many nodes allocate beyond those of the constructor.
  static size_t later_bytes(int64_t nodes);

  DevicePotential& potential();
  DevicePreconditioner& preconditioner();

  /// The displacement that is iterated on, (nodes, 3), on the device; solve() may move it.
  double* u();
  /// An array of its size for the next one; accept_trial() makes it u().
  double* trial_u();
  /// The array of trial_u(), for a caller that exchanges it for another one.
  DeviceArray<double>& trial();
  void accept_trial();
  /// Nodal rotations of the preconditioner from u().
  void set_nodal_rotations();
  /// quasi_loop on u() with a first matrix in float. Gradients are in float while |grad Phi| is
  /// above `precise_below` [N], then in double: a value up to the target is float to the end,
  /// infinity is double from the start.
  IterationResult solve(double target, int max_outer, double precise_below,
                        const Interrupted& interrupted);

  // with arrays of the host, for tests and benchmarks
  void begin_step(const IncrementalPotential& host);  ///< takes the step that it has begun
  void set_nodal_rotations(const double* u);
  void update_contact(bool touching);  ///< freezes its stiffness at u(); false: there is none
  void download_u(double* u);
  IterationResult solve(double* u, double target, int max_outer, double precise_below,
                        const Interrupted& interrupted);

  /// z = B r, both (nodes, 3) on the device; for tests and benchmarks. T float or double.
  template <class T>
  void precondition(const T* r, T* z);

  struct Impl;

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace elastogen::cuda
