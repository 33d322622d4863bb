// SPDX-License-Identifier: Apache-2.0
// Linear momentum of pieces that nothing holds or touches. The sum of the equations of such a piece
// has no elastic forces in it: its centre of mass moves with the predictor, whatever the tolerance,
//
//     sum_n m_n x_n = sum_n m_n xhat_n.

#pragma once

#include "core/scene.hpp"

#include <algorithm>
#include <vector>

namespace elastogen {

/// Whether a node of each piece is pinned, or fixed along an axis, (pieces).
std::vector<uint8_t> held_pieces(const Scene& scene);
/// Nodes of each piece that is not held.
std::vector<std::vector<int32_t>> free_pieces(const Scene& scene);

class FreeFlight {
 public:
  explicit FreeFlight(const Scene& scene);

  /// A piece without pinned nodes is there.
  bool exists() const { return exists_; }

  /// Shifts each free piece's values, (nodes, 3), by one vector so that their mean, weighted with
  /// mass, is that of aim(n, d).
  template <class Aim>
  void match_means(double* values, const Aim& aim) {
    std::fill(excess_.begin(), excess_.end(), Vec3{});
    const auto nodes = size_t(scene_.grid.node_count());
    for (size_t n = 0; n < nodes; ++n)
      for (size_t d = 0; d < 3; ++d)
        excess_[piece(n)][d] += scene_.mass(int64_t(n)) * (values[3 * n + d] - aim(n, d));
    for (size_t n = 0; n < nodes; ++n)
      for (size_t d = 0; d < 3; ++d)
        values[3 * n + d] -= excess_[piece(n)][d] * per_mass_[piece(n)];
  }

 private:
  size_t piece(size_t n) const { return size_t(scene_.grid.piece(int64_t(n))); }

  const Scene& scene_;
  bool exists_ = false;
  std::vector<double> per_mass_;  // of the pieces [1/kg], 0 where a node is pinned
  std::vector<Vec3> excess_;      // of the pieces
};

}  // namespace elastogen
