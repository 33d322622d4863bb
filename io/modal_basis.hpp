// SPDX-License-Identifier: Apache-2.0
// Displacement modes of an animation (principal components by the method of snapshots), with the
// largest error that they leave.

#pragma once

#include "core/array.hpp"

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace elastogen {

/// Row-major 3x3.
using Matrix3 = std::array<double, 9>;

/// A moving point set: frame t moves vertex v by d_tv [m].
struct Motion {
  int64_t frames = 0, vertices = 0;
  /// writes d of the vertices first, ..., first + count - 1 of a frame, (count, 3)
  std::function<void(int64_t frame, int64_t first, int64_t count, float* d)> read;
  /// between the numbers of the mesh and metres: d = to_metres d_mesh, d_mesh = to_mesh d
  Matrix3 to_metres = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  Matrix3 to_mesh = {1, 0, 0, 0, 1, 0, 0, 0, 1};
};

/// d_t is about sum_k weights_tk modes_k with modes_k = sum_s shares_sk d_(snapshots_s).
struct ModalBasis {
  Array<float> weights;            ///< (frames, modes), at most 1 in size; a still frame: 0
  std::vector<int64_t> snapshots;  ///< frames of which the modes are made, none of them still
  Array<double> shares;            ///< (snapshots, modes); empty: one mode a snapshot
  double max_error = 0;            ///< over all frames and vertices, as stored in float32 [m]

  int modes() const { return weights.cols(); }
};

inline constexpr int kMaxModes = 64;
inline constexpr int kMaxSnapshots = 256;

/// The smallest basis of at most 64 modes whose largest error does not exceed `tolerance` [m], or
/// the best of 64. The error is measured on modes and weights rounded to float32. Of more than 256
/// moving frames 256 evenly spaced ones are the snapshots; the weights fit every frame.
/// Memory does not grow with frames times vertices. The same bits on every run.
ModalBasis modal_basis(const Motion& motion, double tolerance);

/// One mode for each frame that moves, with weight 1 there.
ModalBasis keyframe_basis(const Motion& motion);

/// Modes in the numbers of the mesh, rounded to float32, (modes, 3 vertices).
Array<float> mode_shapes(const Motion& motion, const ModalBasis& basis);

}  // namespace elastogen
