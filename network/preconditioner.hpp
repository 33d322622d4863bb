// SPDX-License-Identifier: Apache-2.0
// RNN-2's one pass: V-cycle plus encoder in nodal rotations, scaled at nodes in contact,
//
//     z = S R ( MG + B A_r^-1 B^T ) R^T S r,     S_n = across I + (along - across) n n^T,
//     along = (1 + k_n/D_n)^(-1/2),  across likewise with the stiffness of friction,
//
// R the block diagonal of nodal rotations at the start of the step, k the nodal stiffness of the
// contact, D the diagonal of the elastic operator. Symmetric and positive definite: the first
// matrix of L-BFGS and the preconditioner of CG.

#pragma once

#include "network/encoder.hpp"
#include "network/multigrid.hpp"

#include <optional>

namespace elastogen {

template <class T>
class Preconditioner {
 public:
  /// @param with_encoder  small time steps do without (docs/physics.md).
  Preconditioner(IncrementalPotential& potential, bool with_encoder);

  /// z = B r, both (nodes, 3); In is the type of the iteration, the work is done in T.
  template <class In>
  void apply(const In* r, In* z);

  /// Takes the frozen contact stiffness of the potential.
  void update_contact();

 private:
  const IncrementalPotential& potential_;
  Multigrid<T> multigrid_;
  std::optional<Encoder<T>> encoder_;
  std::vector<T> r_, z_;
  std::vector<float> along_, across_;  // S per node; empty while nothing is in contact
};

}  // namespace elastogen
