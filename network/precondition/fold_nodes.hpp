// SPDX-License-Identifier: Apache-2.0
// Where a first matrix is corrected for folds (fold_patch.hpp, for the host; fold_patch.cuh, for a
// card): the nodes of voxels whose frames lie far from those of their nodes and of voxels beside them,
// and which nodes the Hessian couples there.

#pragma once

#include "core/scene.hpp"

#include <array>
#include <vector>

namespace elastogen {

/// Cosine of the angle between frames from which on they lie far apart.
inline constexpr double kFoldCosine = 0.7;

class FoldNodes {
 public:
  /// The scene must outlive this.
  explicit FoldNodes(const Scene& scene);

  /// Finds all of below. Repeats to the bit.
  /// @param apart  voxels whose frames lie far from those of their nodes, ascending.
  void find(const std::vector<int32_t>& apart);
  /// Whether a patch that was found for others has all of these voxels.
  bool cover(const std::vector<int32_t>& apart) const;
  void clear() { nodes.clear(); }
  bool empty() const { return nodes.empty(); }
  int64_t count() const { return int64_t(nodes.size()); }

  /// An entry of the rows below.
  struct Entry {
    int32_t row, number;
  };

  std::vector<int32_t> nodes;    ///< of the patch: free along all axes, no other node follows them
  std::vector<int32_t> reached;  ///< these, then free nodes beside them
  std::vector<int32_t> place;    ///< of each node of the grid among reached, -1 if it is none
  std::vector<int32_t> voxels;   ///< with a node of the patch, ascending
  /// Rows of nodes, (count + 1); their columns are places among reached, ascending.
  std::vector<int32_t> begin, columns;
  /// The entries of each column, (reached + 1), in the order of the rows.
  std::vector<int32_t> first;
  std::vector<Entry> transposed;

 private:
  bool is_plain(int64_t node) const;
  void find_nodes(const std::vector<int32_t>& apart);
  void find_columns();
  void find_transposed();

  const Scene& scene_;
  std::vector<uint8_t> is_parent_;  // empty: no node follows others
};

/// Chebyshev's iteration for eigenvalues of [0.05 b, b], from 0: d = keep d + add/b D^-1 (r - H z),
/// z += d.
struct FoldSmoother {
  static constexpr int kDegree = 4;
  std::array<double, kDegree> keep, add;
};
FoldSmoother fold_smoother();

/// The largest eigenvalue b of D^-1 H is taken as this times what the power method finds in so many
/// products, from the vector of this value for number k.
inline constexpr double kFoldMargin = 1.1;
inline constexpr int kFoldPowers = 10;
ELASTOGEN_HD inline float fold_power_start(uint32_t k) {
  return float((k * 2654435761u >> 8) % 1000) / 1000 - 0.5f;
}

}  // namespace elastogen
