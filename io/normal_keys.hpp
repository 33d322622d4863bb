// SPDX-License-Identifier: Apache-2.0
// Normals of a clip as separate morph targets: the normals of a few key frames, between which
// weights change linearly.
//
// A client adds weighted changes of the normal at rest and scales the sum to length one. Some
// (Filament) store each target as a rotation, which loses its length. A target must therefore be a
// normal of length one by itself. Normals of frames are, those of principal modes are not: for this
// reason displacements and normals have separate targets.

#pragma once

#include "core/array.hpp"
#include "io/modal_basis.hpp"

namespace elastogen {

/// Goal for the largest root mean square, over the vertices of a frame, of the angle between shown
/// and true normals [rad]: about 5 of 255 in a shaded picture.
inline constexpr double kNormalTolerance = 0.02;

struct NormalKeys {
  std::vector<int64_t> frames;  ///< whose normals are targets, ascending
  Array<float> weights;         ///< (frames of the range, keys), 0 ... 1
  double error = 0;             ///< largest root mean square angle of a frame [rad]
};

/// Key frames for a range, added where linear interpolation is worst, until `tolerance` is met or
/// there are `most` of them, at least 2. Still frames are free keys, without a weight.
/// @param normals  of some vertices in every frame of the clip, of length one,
///                 (clip's frames, 3 vertices).
/// @param moving   the range's frames that move, ascending.
NormalKeys normal_keys(const Array<float>& normals, const FrameRange& range,
                       const std::vector<int64_t>& moving, int most,
                       double tolerance = kNormalTolerance);

}  // namespace elastogen
