// SPDX-License-Identifier: Apache-2.0
// The displacements of shown meshes as morph targets.

#pragma once

#include "io/asset.hpp"
#include "io/clip_pieces.hpp"
#include "io/frame_store.hpp"

namespace elastogen {

/// Shown meshes that touch, and the pieces of the clip that they share: with the same weights
/// vertices at one place stay at one place.
struct MorphGroup {
  std::vector<size_t> instances;  ///< rows of Surface::instances
  Motion motion;                  ///< a part for each instance
  std::vector<ClipPiece> pieces;  ///< empty where nothing moves
};

/// Targets of one mesh in one piece. Rows hold deltas in the mesh's numbers.
struct MorphTargets {
  Array<float> position;          ///< (rows, 3 drawn vertices)
  Array<float> normal;            ///< the same of the normals; empty where the mesh has none
  std::vector<int> position_row;  ///< of each target; -1: no delta
  std::vector<int> normal_row;    ///< the same, empty where the mesh has none

  int count() const { return int(position_row.size()); }
};

/// Instances with triangles, those together of which one vertex lies within the weld's tolerance
/// (io/weld.hpp) of a vertex of another.
std::vector<std::vector<size_t>> touching_instances(const Surface& surface);

/// Fits pieces to instances. A displacement d in metres becomes d_mesh = A^+ d with A = s W, s the
/// scale of the surface, W the linear part of the node's world matrix; what A^+ cannot give (a node
/// scaled to zero) counts as error.
/// @param frames  rows of displacements [m] of the whole surface, (frames, 3 vertices).
MorphGroup morph_group(const Asset& asset, const Surface& surface, std::vector<size_t> instances,
                       const FrameStore& frames, const PieceOptions& options);

/// Targets of an instance of a group in a piece of it.
/// @param part  which instance, row of group.instances.
MorphTargets morph_targets(const Asset& asset, const Surface& surface, const MorphGroup& group,
                           size_t part, const ClipPiece& piece);

}  // namespace elastogen
