// SPDX-License-Identifier: Apache-2.0
// The correction of folds of fold_patch.hpp on the device. The host lists the nodes of the patch
// (fold_nodes.hpp) from the voxels that the device finds; a warp multiplies each row of H.

#pragma once

#include "network/potential/incremental_potential_device.hpp"

namespace elastogen::cuda {

class DeviceFoldPatch {
 public:
  /// Allocates nothing on the device. The potential must outlive this.
  explicit DeviceFoldPatch(DevicePotential& potential);
  ~DeviceFoldPatch();

  /// Finds the patch at u [m], and its matrices of voxels: before the potential is linearised at u,
  /// whose frozen tangents it overwrites. Waits for the device. Where that has no memory for it,
  /// there is no patch.
  void find(const double* u);
  /// Adds up H of the patch, unless it is empty: after the potential was linearised.
  void assemble();
  void clear();
  bool empty() const;
  int64_t count() const;  ///< of its nodes

  /// Starts z_1 = S r and r - H z_1, which it returns; arrays are (nodes, 3) on the device.
  const float* begin(const float* r);
  /// Starts z = z_1 + z + S (r - H z), r that which begin() returned.
  void end(float* z);

  struct Impl;

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace elastogen::cuda
