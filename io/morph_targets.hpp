// SPDX-License-Identifier: Apache-2.0
// Displacements of shown meshes as morph targets.

#pragma once

#include "io/asset.hpp"
#include "io/clip_pieces.hpp"
#include "io/frame_store.hpp"

namespace elastogen {

/// Shown meshes that touch, and the pieces of the clip that they share. With common weights
/// vertices at one place stay at one place.
struct MorphGroup {
  std::vector<size_t> instances;  ///< rows of Surface::instances
  Motion motion;                  ///< a part for each instance
  std::vector<ClipPiece> pieces;  ///< empty where nothing moves
};

/// Targets of one mesh in one piece. Rows hold deltas in the mesh's numbers.
struct MorphTargets {
  Array<float> position;  ///< (rows, 3 drawn vertices)
  Array<float> normal;    ///< of the normals, (rows, 3 drawn vertices); empty without normals
  std::vector<int> position_row;  ///< row of position for each target; -1: no delta
  std::vector<int> normal_row;    ///< row of normal for each target; empty without normals

  int count() const { return int(position_row.size()); }
};

/// Instances with triangles, in groups. Two belong to one group if a vertex of one lies within the
/// weld's tolerance (io/weld.hpp) of a vertex of the other.
std::vector<std::vector<size_t>> touching_instances(const Surface& surface);

/// Fits pieces to instances. A displacement d in metres becomes d_mesh = A^+ d with A = s W, where
/// s is the scale of the surface and W the linear part of the node's world matrix. The part of d
/// that A^+ loses (a node scaled to zero) counts as error.
/// @param frames  rows of displacements [m] of the whole surface, (frames, 3 vertices).
MorphGroup morph_group(const Asset& asset, const Surface& surface, std::vector<size_t> instances,
                       const FrameStore& frames, const PieceOptions& options);

/// Targets of an instance of a group in a piece of it.
/// @param part  index of the instance in group.instances.
MorphTargets morph_targets(const Asset& asset, const Surface& surface, const MorphGroup& group,
                           size_t part, const ClipPiece& piece);

}  // namespace elastogen
