// SPDX-License-Identifier: Apache-2.0
// RNN-2's one pass: V-cycle plus encoder in nodal rotations,
//
//     z = R ( MG + B (A_r^-1 - s D_r^-1) B^T ) R^T r        (network/precondition/encoder.hpp),
//
// R the block diagonal of nodal rotations at the start of the iteration. Contact adds the stiffness
// K of its nodes to both: its diagonal in the rotated frames to multigrid, the 3x3 blocks to A_r.
// Symmetric and positive definite: the first matrix of L-BFGS and the preconditioner of CG, which may
// correct it in folds (fold_patch.hpp).

#pragma once

#include "network/precondition/encoder.hpp"
#include "network/precondition/fold_patch.hpp"
#include "network/precondition/multigrid.hpp"

#include <optional>

namespace elastogen {

/// Whether a preconditioner has an encoder.
struct EncoderChoice {
  bool wanted = true;         ///< small time steps do without (docs/physics.md)
  double least_softness = 0;  ///< of Encoder::softness() below which it is left out as well

  /// The encoder, or none.
  template <class T>
  std::optional<Encoder<T>> make(const IncrementalPotential& potential) const {
    if (!wanted) return {};
    if (least_softness > 0) return Encoder<T>::if_soft(potential, least_softness);
    return Encoder<T>(potential);
  }
};

template <class T>
class Preconditioner {
 public:
  /// @param dense  as in Multigrid.
  Preconditioner(IncrementalPotential& potential, const EncoderChoice& encoder,
                 std::optional<int64_t> dense = {});

  /// z = B r, both (nodes, 3); In is the type of the iteration, the work is done in T.
  template <class In>
  void apply(const In* r, In* z);

  /// Uses the frozen contact stiffness of the potential.
  void update_contact();

  /// Corrects folds at u, where the Hessian of the potential is frozen, until clear_folds().
  void update_folds(const double* u) { patch_.update(potential_, u); }
  void clear_folds() { patch_.clear(); }
  bool has_folds() const { return !patch_.empty(); }

  /// Uses inertia and damping of the potential's present scheme, without contact. It was built with
  /// the inertia of the first one.
  void update_inertia();

  const Encoder<T>* encoder() const { return encoder_ ? &*encoder_ : nullptr; }

 private:
  template <class From, class In>
  void apply_plain(const From* r, In* z);

  IncrementalPotential& potential_;
  FoldPatch patch_;
  Multigrid<T> multigrid_;
  std::optional<Encoder<T>> encoder_;
  Zeroed<T> r_, z_, left_, first_;
  double built_with_, used_;  // a0 / dt^2 [1/s^2]
  double scale_ = 1;          // of the inverse
  bool in_contact_ = false;
};

}  // namespace elastogen
