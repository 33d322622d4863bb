// SPDX-License-Identifier: Apache-2.0
// What pins hold, and moves. The network and finite elements hold the body at their borders where these
// cut voxels (voxelize/dependent_nodes.hpp) or tetrahedra (tet_pins.hpp); the solver 'paper' holds the
// nodes in them.

#pragma once

#include "scene/set_up.hpp"
#include "voxelize/voxelize.hpp"

namespace elastogen {

/// The extents of a box, for messages.
std::string span_of(const PlacedBox& box);

/// What a move does. @param box  of the asset [m].
Holder holder_of(const Move& move, const PlacedBox& box);

/// Borders of pins and moves in an order of their own, each once, and the planes of nodes that they ask for;
/// neither where the steps of the run hold nodes. @param box  of the asset [m].
void add_borders(const RunDescription& run, const PlacedBox& box, VoxelizeOptions& options);

/// Fills what holds the nodes of the scene; warns of pins, holds and moves that hold nothing, but for
/// pins and moves of a file's tetrahedra (hold_tets). Holds are only checked.
/// @throws Error (usage) naming two options, one of them a move, that have a point, node or border in common.
/// @param borders  of the options that the grid was made with.
/// @param cut      by them (Voxelized).
void pin(const RunDescription& run, const std::vector<Border>& borders,
         const std::vector<BorderVoxel>& cut, Setup& setup);

/// The points behind borders.
std::vector<HeldPoint> points_behind(const std::vector<HeldBorder>& borders, const PlacedBox& box,
                                     In<double> points);
/// Sets their weights to 0. @return these points.
std::vector<HeldPoint> rest_behind(const std::vector<HeldBorder>& borders, const PlacedBox& box,
                                   In<double> points, Array<double>& weights);

}  // namespace elastogen
