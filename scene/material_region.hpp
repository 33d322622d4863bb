// SPDX-License-Identifier: Apache-2.0
// A material for a part of the asset, as text and as values.

#pragma once

#include "mpm_fem/fem/element_mesh.hpp"
#include "mpm_fem/materials/solid.hpp"
#include "voxelize/body.hpp"
#include "voxelize/regions.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace elastogen {

struct MaterialRegion {
  enum class Kind { kPlace, kNode, kMaterial };
  std::string text;  ///< as it was said, for messages
  Kind kind = Kind::kPlace;
  Selection selection;  ///< of the voxels' centres
  std::string name;     ///< of nodes or of the asset's materials; * stands for any letters
  Material material;
  Yield yield = {};
};

/// Reads 'SELECTION: MATERIAL', where SELECTION is that of --pin, node:NAME or material:NAME, and
/// MATERIAL a preset that may be followed by changes: ,young=2MPa ,poisson=0.4 ,density=900
/// ,law=stvk, and those of change_solid.
/// @throws Error (usage) naming the text and what is wrong.
MaterialRegion parse_region(std::string_view text);

/// Gives the voxels of each region its material, later ones on top of earlier ones; a material that
/// no voxel is left with is not kept. A region of the asset's nodes or materials takes the voxels
/// whose nearest triangle belongs to it, for a node also those of the nodes below.
/// @param scene     with grid, materials and material.
/// @param yields    of each material.
/// @param warnings  gets a sentence for each region that holds no voxel.
/// @throws Error (usage) on a name that the asset does not have, listing those it has.
void apply_regions(const std::vector<MaterialRegion>& regions, const Asset& asset, const Body& body,
                   Scene& scene, std::vector<Yield>& yields, std::vector<std::string>& warnings);

/// The same for tetrahedra, by their centroids, or by the numbers of the file's regions in place of
/// the names of materials.
/// @param region_of  index into of_file of each, (elements, 1).
/// @param of_file    the file's regions, whose names are their numbers.
/// @param box        of the surface [m].
void apply_regions(const std::vector<MaterialRegion>& regions, const fem::ElementMesh& mesh,
                   In<int32_t> region_of, const std::vector<AssetMaterial>& of_file,
                   const PlacedBox& box, Scene& scene, std::vector<Yield>& yields,
                   std::vector<std::string>& warnings);

}  // namespace elastogen
