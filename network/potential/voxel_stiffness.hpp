// SPDX-License-Identifier: Apache-2.0
// The Hessian voxel by voxel, from the tangents that a potential has frozen.

#pragma once

#include "network/potential/incremental_potential.hpp"

namespace elastogen {

class VoxelStiffness {
 public:
  /// Finds the rotations of all voxels at u [m], (nodes, 3). The potential must outlive this.
  VoxelStiffness(IncrementalPotential& potential, const double* u);

  const IncrementalPotential& potential() const { return of_; }
  /// The rotation of F_v; 0 where F_v determines none.
  Mat3<double> frame(int64_t voxel) const;
  /// The frozen Hessian of a voxel without negative eigenvalues [N/m], (24, 24), row-major; component i
  /// of corner c is 3 c + i. Inertia and contact are not in it.
  void matrix(int64_t voxel, double* K) const;

 private:
  VoxelData<double> data(int64_t voxel) const;

  IncrementalPotential& of_;
};

}  // namespace elastogen
