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

/// 1 for each node that an option selects, (nodes, 1); warns if there is none.
Array<uint8_t> held_nodes(const std::string& option, const Selection& selection, Setup& setup);

/// Whether nodes hold a part where its border lies; the setup has a grid.
bool fits_grid(const std::optional<Border>& border, const Setup& setup);

/// What a move does. @param box  of the asset [m].
Holder holder_of(const Move& move, const PlacedBox& box);

/// Borders of pins and moves in an order of their own, each once, and the planes of nodes that they ask for;
/// neither where the steps of the run hold nodes. @param box  of the asset [m].
void add_borders(const RunDescription& run, const PlacedBox& box, VoxelizeOptions& options);

/// Fills what holds the nodes of the scene; warns of pins and moves that hold nothing, but for those of a
/// file's tetrahedra (hold_tets). Holds follow (scene/holds.hpp).
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
