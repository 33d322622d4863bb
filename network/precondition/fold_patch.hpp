// SPDX-License-Identifier: Apache-2.0
// A correction of the first matrix P, V-cycle and encoder, where its form fails: in folds the frames of
// a voxel and of its nodes lie far apart, and no operator of constant coefficients in nodal frames is
// near the Hessian H. With S a Chebyshev smoother of H on the nodes of such voxels and beside them,
//
//     z_1 = S r,     z_2 = z_1 + P (r - H z_1),     z = z_2 + S (r - H z_2).
//
// H is here that of the voxels without negative eigenvalues, with the stiffness of contact: z is a
// symmetric positive definite map of r.

#pragma once

#include "network/potential/voxel_stiffness.hpp"
#include "network/precondition/fold_nodes.hpp"

#include <optional>

namespace elastogen {

class FoldPatch {
 public:
  /// Finds the voxels whose frames at u [m], where the Hessian is frozen, lie far from those of their
  /// nodes, and assembles H there. Repeats to the bit.
  void update(IncrementalPotential& potential, const double* u);
  void clear() {
    if (of_) of_->clear();
  }
  bool empty() const { return !of_ || of_->empty(); }
  int64_t count() const { return of_ ? of_->count() : 0; }  ///< of its nodes

  /// z_1 = S r and r -= H z_1; both (nodes, 3), z_1 only on nodes of the patch.
  template <class T>
  void begin(T* r, T* z_1);
  /// z = z_1 + p + S (r - H p), where p = P r of the r that begin() left.
  template <class T, class Z>
  void end(const T* r, const T* z_1, Z* p);

 private:
  void add_voxels(const VoxelStiffness& stiffness);
  void add_contact(const Contact& contact);
  template <class Value>
  void add_block(const int32_t* corners, int a, int b, const Value& value);
  void find_inverses();
  void find_bound();
  void product(const Zeroed<float>& x, Zeroed<float>& y) const;
  template <class T>
  void gather(const std::vector<int32_t>& nodes, const T* from, Zeroed<float>& to) const;
  void smooth();

  std::optional<FoldNodes> of_;
  // H by rows of its nodes
  Zeroed<float> blocks_, inverse_;          // 3x3; inverse_: of the diagonal blocks
  double bound_ = 0;                        // of the eigenvalues of D^-1 H
  Zeroed<float> right_, z_, d_, Hz_, far_;  // of the patch; far_ of the nodes reached
};

}  // namespace elastogen
