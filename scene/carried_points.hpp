// SPDX-License-Identifier: Apache-2.0
// The points of an asset that a run moves, and the frames made of them.

#pragma once

#include "network/solver.hpp"
#include "scene/set_up.hpp"
#include "voxelize/embedding.hpp"

namespace elastogen {

/// Points carried by voxels, or points that are nodes of tetrahedra.
struct CarriedPoints {
  int64_t count = 0;
  Embedding embedding;                      ///< in the voxels of the scene's grid
  const Array<int32_t>* node_of = nullptr;  ///< node of each point, (points, 1); null: embedded
  std::vector<HeldPoint> moved;             ///< points that go with holders that move
};

/// The carried points of a setup, which must outlive them.
CarriedPoints carried_points(const Setup& setup);

/// Puts the points that go with holders where these are at a time [s].
/// @param gradient  deformation gradients of the points, null: none.
void place_moved(const CarriedPoints& points, const Setup& setup, double time,
                 Array<double>& displacement, Array<double>* gradient);

/// Frames made from positions of nodes. The last two remain valid, so one may be written while the
/// next is made.
class NodeFrames {
 public:
  /// Grid and points must outlive it.
  NodeFrames(const VoxelGrid& grid, const CarriedPoints& points, bool with_gradient);

  /// Makes a frame. @param x  positions [m], (nodes, 3), the first nodes being those of the grid.
  /// @return its number, from 0.
  int64_t make(In<double> x);

  /// One of the last two frames.
  CarriedFrame take(int64_t number) const;

 private:
  struct Frame {
    Array<double> displacement, gradient;
  };

  const VoxelGrid& grid_;
  const CarriedPoints& points_;
  Frame frames_[2];
  int64_t count_ = 0;
};

}  // namespace elastogen
