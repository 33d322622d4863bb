// SPDX-License-Identifier: Apache-2.0
// The low-frequency encoder: smooth modes of each connected piece, Galerkin with the elastic
// operator at rest. Added to multigrid it makes the iteration counts nearly independent of the time
// step: the scalar hierarchies charge rotations and bending, which elasticity gets nearly for
// nothing.
//
//     B_k = c_k(X) d/(d + L/8),     c_k = prod_d cos(pi k_d (X_d - X_d,min)/L_d) and X, Y, Z,
//     z += B A_r^-1 B^T r,          A_r = B^T A B,
//
// 18 cosines of lowest frequency and the three linear functions for each displacement component; d
// the distance to the nearest pinned node of the piece, L its longest extent (factor 1 where
// nothing is pinned).

#pragma once

#include "core/pack.hpp"
#include "network/incremental_potential.hpp"

#include <vector>

namespace elastogen {

/// Where the modes of a node are.
struct EncoderPlace {
  int32_t piece, local;  ///< and its place there; piece -1: none
};

template <class T>
class Encoder {
 public:
  static constexpr int kModes = 21;
  static constexpr int kPacks = (kModes + kLanes - 1) / kLanes;  ///< that hold the modes of a node

  /// A connected piece; row 3 m + i of A_r is mode m of component i.
  struct Piece {
    std::vector<int32_t> nodes;
    Zeroed<T> modes;              ///< (nodes, kModes), and zeros that fill the last pack; in float
                                  ///< they are numbers of half precision
    std::vector<double> rest;     ///< A_r at rest, (3 kModes, 3 kModes)
    std::vector<double> inverse;  ///< of A_r, the same shape
  };

  /// Builds modes and A_r; the potential must have the scheme that will be used.
  explicit Encoder(const IncrementalPotential& potential);

  /// z += B A_r^-1 B^T r; (nodes, 3).
  void add(const T* r, T* z);

  /// Adds the stiffness of some nodes, symmetric 3x3 blocks [N/m], (stiff nodes, 9), to the
  /// operator, in place of the one added before.
  void set_nodal_stiffness(const std::vector<int32_t>& nodes, const std::vector<double>& blocks);

  /// The modes alone: y = B^T r and z = B y, 3 kModes numbers a piece; for tests.
  void encode(const T* r, double* y) const;
  void decode(const double* y, T* z) const;

  const std::vector<Piece>& pieces() const { return pieces_; }
  int piece_count() const { return int(pieces_.size()); }

 private:
  void find_pieces(const Scene& scene);
  void fill_modes(const Scene& scene, Piece& piece);
  void build_operators(const IncrementalPotential& potential);
  static void load_modes(const Piece& piece, int64_t k, Pack<T> mode[kPacks]);
  static void invert(Piece& piece, const std::vector<double>& A);

  std::vector<Piece> pieces_;
  Zeroed<EncoderPlace> place_;  // of each node
  std::vector<double> reduced_, solution_;
};

}  // namespace elastogen
