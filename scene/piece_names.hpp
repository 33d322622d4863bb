// SPDX-License-Identifier: Apache-2.0
// Names of pieces of an asset, by its nodes.

#pragma once

#include "io/asset.hpp"
#include "voxelize/voxelize.hpp"

#include <span>
#include <string>

namespace elastogen {

/// The name of a triangle's node, else of its mesh; empty if the surface is not the asset's own or
/// neither has a name.
std::string name_at(const Asset& asset, const Surface& surface, int64_t triangle);

/// Adds the finding "joined-pieces": the nearest pairs by name, their distance, and the voxel edge
/// that would separate all of them. Points in voxels that share a node are at most 2 h apart along
/// each axis, so a gap above 2 sqrt(3) h is kept.
void add_joined_pieces(const Asset& asset, const Surface& surface, std::span<const PieceGap> gaps,
                       std::vector<Finding>& findings);

}  // namespace elastogen
