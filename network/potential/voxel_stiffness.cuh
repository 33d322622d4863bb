// SPDX-License-Identifier: Apache-2.0
// The Hessian voxel by voxel (voxel_stiffness.hpp) on the device, for the few voxels of a patch.

#pragma once

#include "core/cuda/growing_array.cuh"
#include "core/cuda/reduce.cuh"
#include "core/cuda/signal.cuh"
#include "network/potential/incremental_potential.cuh"

namespace elastogen::cuda {

class DeviceVoxelStiffness {
 public:
  /// Allocates nothing. The potential must outlive this.
  explicit DeviceVoxelStiffness(DevicePotential& potential) : of_(potential.impl()) {}

  /// Voxels whose frames at u [m] lie farther than by the angle of that cosine from the frame of one
  /// of their nodes, ascending. Waits for the device.
  /// @throws Error (resources) if it has too little memory.
  std::vector<int32_t> apart(const double* u, double cosine);

  /// Finds the matrices of some voxels at u; the tangents that the potential has frozen become those
  /// without negative eigenvalues.
  void update(const double* u, const std::vector<int32_t>& voxels);
  /// [N/m], (voxels, 24, 24); component i of corner c is 3 c + i. Inertia and contact are not in it.
  const float* matrices() const { return matrices_.data(); }
  static constexpr int64_t kEntries = 24 * 24;

 private:
  void find_slots();

  DevicePotential::Impl& of_;
  std::vector<int32_t> slot_, voxel_;       // of each voxel, and of each slot; -1 if none
  GrowingArray<Quaternion<float>> frames_;  // of voxels by slot
  GrowingArray<uint8_t> flags_;             // of slots
  GrowingArray<SumScratch<Sums<1>>> sums_;
  PinnedArray<double> count_{1};  // of flags that are set
  Signal signal_;
  GrowingArray<int32_t> slots_;  // of the voxels with matrices
  GrowingArray<float> matrices_;
};

}  // namespace elastogen::cuda
