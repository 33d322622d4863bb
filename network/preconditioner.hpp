// SPDX-License-Identifier: Apache-2.0
// RNN-2's one pass: V-cycle plus encoder in nodal rotations,
//
//     z = R ( MG + B (A_r^-1 - s D_r^-1) B^T ) R^T r        (network/encoder.hpp),
//
// R the block diagonal of nodal rotations at the start of the iteration. Contact adds the stiffness
// K of its nodes to both: its diagonal in the rotated frames to multigrid, the 3x3 blocks to A_r.
// Symmetric and positive definite: the first matrix of L-BFGS and the preconditioner of CG.

#pragma once

#include "network/encoder.hpp"
#include "network/multigrid.hpp"

#include <optional>

namespace elastogen {

template <class T>
class Preconditioner {
 public:
  /// @param with_encoder   small time steps do without (docs/physics.md).
  /// @param least_softness  of Encoder::softness() below which the encoder is left out as well.
  Preconditioner(IncrementalPotential& potential, bool with_encoder, double least_softness = 0);

  /// z = B r, both (nodes, 3); In is the type of the iteration, the work is done in T.
  template <class In>
  void apply(const In* r, In* z);

  /// Takes the frozen contact stiffness of the potential.
  void update_contact();

  const Multigrid<T>& multigrid() const { return multigrid_; }
  const Encoder<T>* encoder() const { return encoder_ ? &*encoder_ : nullptr; }

 private:
  const IncrementalPotential& potential_;
  Multigrid<T> multigrid_;
  std::optional<Encoder<T>> encoder_;
  Zeroed<T> r_, z_;
  bool in_contact_ = false;
};

}  // namespace elastogen
