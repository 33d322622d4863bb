// SPDX-License-Identifier: Apache-2.0
// The displacement of one shown mesh as morph targets.

#pragma once

#include "io/asset.hpp"
#include "io/frame_store.hpp"
#include "io/modal_basis.hpp"

namespace elastogen {

struct MorphTargets {
  Array<float> position;  ///< deltas in the mesh's numbers, (targets, 3 drawn vertices)
  Array<float> normal;    ///< the same of the normals; empty where the mesh has none
  Array<float> weights;   ///< (frames, targets)
  double max_error = 0;   ///< over all frames and vertices [m]
};

/// Morph targets of an instance from the displacements of its surface. A displacement d in metres
/// becomes d_mesh = A^+ d with A = s W, s the scale of the surface, W the linear part of the
/// node's world matrix; what A^+ cannot give (a node scaled to zero) counts as error.
/// @param frames     rows of displacements [m] of the whole surface, (frames, 3 vertices).
/// @param tolerance  largest error of the modes [m]; 0: one target a moving frame.
MorphTargets morph_targets(const Asset& asset, const Surface& surface,
                           const SurfaceInstance& instance, const FrameStore& frames,
                           double tolerance);

}  // namespace elastogen
