// SPDX-License-Identifier: Apache-2.0
// What pins hold. The network on the host and finite elements on voxels hold the body at their borders
// where these cut voxels (voxelize/dependent_nodes.hpp); all other steps hold the nodes in a pin.

#pragma once

#include "scene/set_up.hpp"
#include "voxelize/voxelize.hpp"

namespace elastogen {

/// Borders of the pins in an order of their own, each once, and the planes of nodes that they ask for;
/// neither where the steps of the run hold nodes. @param box  of the asset [m].
void add_borders(const RunDescription& run, const PlacedBox& box, VoxelizeOptions& options);

/// Pins the scene; warns of pins, holds and moves that hold nothing. Holds and moves are only checked.
/// @param borders  of the options that the grid was made with.
/// @param cut      by them (Voxelized).
void pin(const RunDescription& run, const std::vector<Border>& borders,
         const std::vector<BorderVoxel>& cut, Setup& setup);

/// Sets the weights of points behind borders to 0: they rest.
void rest_behind(const std::vector<Border>& borders, const PlacedBox& box, In<double> points,
                 Array<double>& weights);

}  // namespace elastogen
