// SPDX-License-Identifier: Apache-2.0
// What selections of the asset's nodes, materials, colours and attributes have of a body.

#pragma once

#include "io/asset.hpp"
#include "scene/description.hpp"
#include "scene/tet_asset.hpp"
#include "voxelize/body.hpp"

namespace elastogen {

struct Setup;

/// A part of the asset (a Selection that is no place). Its voxels are those whose centre has its
/// nearest place of the surface in the part: on a triangle of the node (or of nodes below it) or of
/// the material, or where the interpolated colour or attribute is as asked for. Of points and splats
/// the nearest one decides. Its points are vertices of such triangles, and painted vertices, each
/// with all vertices at its very place.
struct AssetPart {
  Selection selection;
  Array<uint8_t> elements;  ///< 1 for its voxels or tetrahedra, (elements, 1)
  Array<uint8_t> points;    ///< 1 for its points, (carried points, 1); of tetrahedra: empty
  Array<uint8_t> nodes;     ///< 1 for corners of its elements and nodes that carry its points,
                            ///< (nodes, 1)
};

/// Whether an option of a run selects by an attribute.
bool asks_for_attributes(const RunDescription& run);

/// The parts that options of a run select, each once.
/// @throws Error (usage) naming the option: a name that the asset does not have, with those it has.
std::vector<AssetPart> asset_parts(const RunDescription& run, const Asset& asset, const Body& body,
                                   const VoxelGrid& grid);

/// Parts of tetrahedra: numbers of the file's regions as materials.
std::vector<AssetPart> asset_parts(const RunDescription& run, const TetAsset& tets);

/// The part that a selection has. It must be one of them.
const AssetPart& part_of(const std::vector<AssetPart>& parts, const Selection& selection);

/// 1 for each node of the grid in a selection at rest, (nodes, 1).
Array<uint8_t> selected_nodes(const Setup& setup, const Selection& selection);

/// Whether a selection has a point that the body carries.
bool has_point(const Setup& setup, const Selection& selection, int64_t point);

}  // namespace elastogen
