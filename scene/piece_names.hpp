// SPDX-License-Identifier: Apache-2.0
// Pieces of an asset as its user knows them: by the names of nodes.

#pragma once

#include "io/asset.hpp"
#include "voxelize/voxelize.hpp"

#include <span>
#include <string>

namespace elastogen {

/// The name of the node that a triangle of the surface belongs to, else of its mesh; empty where
/// the surface is not the asset's own or neither has a name.
std::string name_at(const Asset& asset, const Surface& surface, int64_t triangle);

/// Adds the finding "joined-pieces": the nearest pairs by name, how far they are apart, and the
/// voxel edge that would part them all. Points in voxels that share a node are at most 2 h apart
/// along each axis, so a gap above 2 sqrt(3) h is kept.
void add_joined_pieces(const Asset& asset, const Surface& surface, std::span<const PieceGap> gaps,
                       std::vector<Finding>& findings);

}  // namespace elastogen
