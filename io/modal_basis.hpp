// SPDX-License-Identifier: Apache-2.0
// Displacements in a range of frames as morph targets with weights in 0 ... 1: principal components
// by the method of snapshots, or one target a frame; and the largest error that remains.

#pragma once

#include "core/array.hpp"

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace elastogen {

/// Row-major 3x3.
using Matrix3 = std::array<double, 9>;

/// Vertices that one mesh shows, and the maps between its own numbers and metres: d = to_metres
/// d_mesh, d_mesh = to_mesh d.
struct MotionPart {
  int64_t first = 0, vertices = 0;  ///< within a frame
  Matrix3 to_metres = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  Matrix3 to_mesh = {1, 0, 0, 0, 1, 0, 0, 0, 1};
};

/// Points that are shown with common weights: frame t moves vertex v by d_tv [m].
struct Motion {
  std::vector<MotionPart> parts;
  /// writes d of the vertices first, ..., first + count - 1 of a frame, (count, 3)
  std::function<void(int64_t frame, int64_t first, int64_t count, float* d)> read;
};

/// Frames first, ..., last of a clip.
struct FrameRange {
  int64_t first = 0, last = 0;
  int64_t count() const { return last - first + 1; }
};

/// d_t is about sum_k weights_tk target_k with target_k = sum_s shares_sk d_(snapshots_s).
struct ModalBasis {
  Array<float> weights;            ///< (frames, targets), 0 ... 1; all 0 in a still frame
  std::vector<int64_t> snapshots;  ///< frames from which targets are made, none of them still
  Array<double> shares;            ///< (snapshots, targets); empty: one target a snapshot
  double max_error = 0;            ///< over all frames and vertices, as stored in float32 [m]

  int targets() const { return weights.cols(); }
};

inline constexpr int kMaxSnapshots = 256;

/// The fewest targets, at most `max_targets`, with a largest error of at most `tolerance` [m]; else
/// the best of those.
///
/// Many programs keep weights within 0 ... 1 (Blender's shape keys). The principal modes m_k of the
/// moving frames d_t = c_t m_0 + sum_k w_tk m_k are therefore stretched, and a carrier that is
/// positive in each of these frames lifts their weights above zero, lo_k = min_t w_tk / c_t:
///
///     target_0 = m_0 + sum_k lo_k m_k,              weight c_t,
///     target_k = m_k max_t (w_tk - lo_k c_t),       weight (w_tk - lo_k c_t) / max_t (...).
///
/// The carrier is the mean with c_t = 1, or, where few modes are needed and that saves a target,
/// the first mode about the rest pose with its own weight, if that never changes sign.
///
/// The error is measured with targets and weights rounded to float32. The snapshots
/// are the moving frames, or 256 evenly spaced ones if there are more; the weights fit every frame.
/// Memory does not grow with frames times vertices. Every run gives the same bits.
ModalBasis modal_basis(const Motion& motion, const FrameRange& frames, double tolerance,
                       int max_targets);

/// One target for each frame that moves, with weight 1 there.
ModalBasis keyframe_basis(const Motion& motion, const FrameRange& frames);

/// Largest part of a displacement [m] that no target can show because its node is scaled to zero.
double unshown_error(const Motion& motion, const FrameRange& frames);

/// Frames of the range in which a vertex moves.
std::vector<int64_t> moving_frames(const Motion& motion, const FrameRange& frames);

/// Targets of a part in the numbers of its mesh, rounded to float32, (targets, 3 vertices).
Array<float> target_shapes(const Motion& motion, const MotionPart& part, const ModalBasis& basis);

}  // namespace elastogen
