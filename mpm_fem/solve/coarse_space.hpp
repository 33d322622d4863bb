// SPDX-License-Identifier: Apache-2.0
// Coarse level of a preconditioner: the rigid motions of groups of neighbouring nodes,
//
//     z += P (P^T A P)^-1 P^T r,
//
// These are rotation and bending, which local preconditioners reduce least (Vanek, Mandel, Brezina
// 1996, without their smoothing).

#pragma once

#include "core/array.hpp"
#include "mpm_fem/solve/sparse_direct.hpp"

namespace elastogen::fem {

class CoarseSpace {
 public:
  /// @param pattern    of the matrices, (3 nodes, 3 nodes)
  /// @param positions  of the nodes [m], (nodes, 3)
  /// @param fixed      1 where an unknown is fixed, (3 nodes): coarse motions are 0 there
  CoarseSpace(const SparseMatrix& pattern, In<double> positions, const uint8_t* fixed);

  int64_t groups() const { return int64_t(first_.size()) - 1; }

  /// Forms and factors P^T A P.
  /// @return false where it is not positive definite
  bool factor(const SparseMatrix& A);

  /// z += P (P^T A P)^-1 P^T r
  void add_correction(const double* r, double* z);

 private:
  void make_groups(const SparseMatrix& pattern);
  void make_pattern(const SparseMatrix& pattern);
  void add_node(const SparseMatrix& A, int64_t n);

  std::vector<int32_t> group_;  // of each node
  std::vector<int32_t> first_;  // first member of each group in members_, and the end
  std::vector<int32_t> members_;
  std::vector<double> motions_;  // P: of each node the motions of its group, (nodes, 3, 6)
  SparseMatrix matrix_;          // P^T A P
  std::vector<double> right_;
  std::unique_ptr<SparseDirect> direct_;
};

}  // namespace elastogen::fem
