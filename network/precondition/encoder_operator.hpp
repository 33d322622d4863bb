// SPDX-License-Identifier: Apache-2.0
// The elastic operator at rest on the modes of the encoder, voxel by voxel: one pass gives the same
// as 63 products with the operator and their projections.

#pragma once

#include "network/precondition/encoder.hpp"

#include <vector>

namespace elastogen {

/// Modes of a connected piece: functions of its nodes, each for all three components.
template <class T>
struct PieceModes {
  const std::vector<int32_t>& nodes;
  const Zeroed<EncoderPlace>& place;   ///< of each node of the grid in `nodes`
  const std::vector<int32_t>& voxels;  ///< of the piece
  const Zeroed<T>& values;             ///< Encoder::Piece::modes
};

/// A_r = B^T A B with A of IncrementalPotential::rest_hessian_product, (3 M, 3 M) for the M modes
/// of B, row 3 m + i mode m of component i. Modes must vanish at pins.
///
/// With d_m the mean gradient of a mode over the fill of a voxel of edge h and fill phi, and
/// q_m its centred patterns xy, yz, zx, xyz (core/hex8.hpp), a voxel gives
///
///     A_mi,nj = phi h^3 [ delta_ij mu d_m.d_n + mu d_mj d_ni + lambda d_mi d_nj ]
///             + phi h [ delta_ij sum_k w_k c_k q_mk q_nk
///                       + ((1 + delta_ij) mu / 48 - delta_ij c_a / 24) q_ma q_nb ],
///
/// w = 1/24 (1/48 for xyz); the last line is the torsion term, a and b the patterns across i and j.
///
/// @param stride  if not 1, the result is an estimate of A_r / stride, from every stride-th block
///                of 128 voxels and nodes. Energies that are 0 in every voxel, as that of a
///                rotation, are 0 in it too.
template <class T>
std::vector<double> reduced_rest_operator(const IncrementalPotential& potential,
                                          const PieceModes<T>& piece, int64_t stride = 1);

}  // namespace elastogen
