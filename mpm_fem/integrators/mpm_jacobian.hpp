// SPDX-License-Identifier: Apache-2.0
// The Jacobian of an implicit step of particles as a sparse matrix: for factors in the plane, where
// they cost little, and for tests, which compare products with it.

#pragma once

#include "mpm_fem/mpm/transfer.hpp"
#include "mpm_fem/solve/assembly.hpp"

#include <functional>

namespace elastogen::mpm {

/// The 3^d nodes of every cell with particles as stencils.
template <int d>
class CellAssembly {
 public:
  /// Sets the cells of a grid. The pattern is made anew only if they have changed.
  void update(const ParticleGrid<d>& grid);

  /// Zero matrix with the entries of all cells, (3 nodes, 3 nodes).
  const fem::SparseMatrix& pattern() const { return pattern_; }
  /// A number that changes with the pattern.
  int64_t version() const { return version_; }

  /// H += sum_p G_p^T D_p G_p, G_p the map from the nodes' motion to its gradient at the particle.
  /// @param tangent  writes D_p of a pack, row-major (9, 9) over the row-major entries of the
  ///                 gradient
  void add(const ParticleGrid<d>& grid, const std::function<void(int64_t pack, Eight* D)>& tangent,
           fem::SparseMatrix& H) const;

 private:
  std::vector<int64_t> first_;  // pack of each cell, and the end
  fem::Assembly assembly_{{}, 0};
  fem::SparseMatrix pattern_;
  int64_t version_ = 0;
};

extern template class CellAssembly<2>;
extern template class CellAssembly<3>;

}  // namespace elastogen::mpm
