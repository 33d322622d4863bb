// SPDX-License-Identifier: Apache-2.0
// The low-frequency encoder: smooth modes of each connected piece, Galerkin with the elastic
// operator at rest. With it the iteration counts hardly depend on the time step: rotations and
// bending cost energy in the scalar hierarchies of multigrid, but nearly none in elasticity.
//
//     B_k = c_k(X) d/(d + L/8),     c_k = prod_d cos(pi k_d (X_d - X_d,min)/L_d) and X, Y, Z,
//     A_r = B^T A B,                alone:              z  = B A_r^-1 B^T r,
//                                   beside multigrid:   z += B (A_r^-1 - s D_r^-1) B^T r,
//
// D_r has the blocks of A_r within a component. Multigrid knows this part of A_r and has answered
// to it already, up to its own error, for which s = 0.8 leaves a margin (less close to nu = 0.5:
// known_share): the sum stays positive definite if multigrid gives at least s - 1/3 of
// B D_r^-1 B^T, as A_r <= 3 D_r. Where A_r is close to
// D_r, in bodies that elastic waves do not cross within a step, the encoder has nothing to add.
//
// The modes of each displacement component are the 18 cosines of lowest frequency and the three
// linear functions; d is the distance to the nearest pinned node of the piece, L its longest extent
// (factor 1 where nothing is pinned).

#pragma once

#include "core/pack.hpp"
#include "network/potential/incremental_potential.hpp"
#include "network/precondition/reduced_operator.hpp"

#include <optional>
#include <vector>

namespace elastogen {

/// Where the modes of a node are stored.
struct EncoderPlace {
  int32_t piece, local;  ///< piece -1: none; index of the node in the piece
};

template <class T>
class Encoder {
 public:
  static constexpr int kModes = kEncoderModes;
  static constexpr int kPacks = (kModes + kLanes - 1) / kLanes;  ///< that hold the modes of a node

  /// A connected piece.
  struct Piece : ReducedOperator {
    std::vector<int32_t> nodes;
    Zeroed<T> modes;  ///< (nodes, kModes), and zeros that fill the last pack; in float they are
                      ///< numbers of half precision
  };

  /// Builds modes and A_r; the potential must have the scheme that will be used.
  explicit Encoder(const IncrementalPotential& potential);

  /// The encoder, or none if softness() is below `least`; for large bodies a sample of their voxels
  /// is tried first.
  static std::optional<Encoder> if_soft(const IncrementalPotential& potential, double least);

  /// z += B A_r^-1 B^T r; (nodes, 3).
  void add(const T* r, T* z) { add(&ReducedOperator::inverse, r, z); }
  /// z += B (A_r^-1 - s D_r^-1) B^T r, beside multigrid.
  void add_correction(const T* r, T* z) { add(&ReducedOperator::correction, r, z); }

  /// The largest ratio of the stiffness that multigrid assumes for a combination of modes to that
  /// of the elastic operator at rest: the largest ReducedOperator::softness of a piece.
  double softness() const;

  /// Adds the stiffness of some nodes, symmetric 3x3 blocks [N/m], (stiff nodes, 9), to the
  /// operator, in place of the one added before.
  void set_nodal_stiffness(const std::vector<int32_t>& nodes, const std::vector<double>& blocks);

  /// Changes the inertia in A_r for steps of another length; removes a nodal stiffness.
  /// @param built, wanted  a0 / dt^2 that it was built with, and that is wanted [1/s^2].
  void set_inertia(const Scene& scene, double built, double wanted);

  /// The modes alone: y = B^T r and z += B y, 3 kModes numbers a piece; for tests.
  void encode(const T* r, double* y) const;
  void decode(const double* y, T* z) const;

  const std::vector<Piece>& pieces() const { return pieces_; }
  int piece_count() const { return int(pieces_.size()); }

 private:
  Encoder() = default;
  void build_modes(const Scene& scene);
  void fill_modes(const Scene& scene, const PinTrees& pins, Piece& piece);
  void fill_dependent(const DependentNodes& dependent);
  std::vector<std::vector<double>> rest_operators(const IncrementalPotential& potential,
                                                  int64_t stride) const;
  void take_operators(const Scene& scene, std::vector<std::vector<double>>&& operators);
  void add_nodal(const std::vector<int32_t>& nodes, const std::vector<double>& blocks,
                 std::vector<std::vector<double>>& A) const;
  static void load_modes(const Piece& piece, int64_t k, Pack<T> mode[kPacks]);
  void add(std::vector<double> ReducedOperator::*matrix, const T* r, T* z);

  std::vector<Piece> pieces_;
  Zeroed<EncoderPlace> place_;  // of each node
  std::vector<double> reduced_, solution_;
  // kReducedSize squared of each piece, once another inertia was asked for: the elastic part of A_r
  // and that of the inertia it was built with
  std::vector<std::vector<double>> elastic_, inertia_;
};

}  // namespace elastogen
