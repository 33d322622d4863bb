// SPDX-License-Identifier: Apache-2.0
// The material of a part of the asset, as text and as values.

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
  std::string text;  ///< as it was typed, for messages
  Kind kind = Kind::kPlace;
  Selection selection;  ///< selects voxels by their centres
  std::string name;     ///< name of nodes or materials of the asset; * stands for any letters
  Material material;
  Yield yield = {};
};

/// Reads 'SELECTION: MATERIAL'. SELECTION is one as in --pin, node:NAME or material:NAME. MATERIAL
/// is a preset, optionally with changes: ,young=2MPa ,poisson=0.4 ,density=900 ,law=stvk, and those
/// of change_solid.
/// @throws Error (usage) naming the text and what is wrong.
MaterialRegion parse_region(std::string_view text);

/// Gives the voxels of each region its material; later regions override earlier ones. Materials
/// that no voxel has in the end are dropped. A region of the asset's nodes or materials has the
/// voxels whose nearest triangle belongs to it; for a node also to nodes below it.
/// @param scene     with grid, materials, and the material of each voxel.
/// @param yields    of each material.
/// @param warnings  gets a sentence for each region that holds no voxel.
/// @throws Error (usage) on a name that the asset does not have, listing its names.
void apply_regions(const std::vector<MaterialRegion>& regions, const Asset& asset, const Body& body,
                   Scene& scene, std::vector<Yield>& yields, std::vector<std::string>& warnings);

/// Gives the tetrahedra of each region its material. Regions select centroids, or numbers of the
/// file's regions in place of names of materials.
/// @param region_of  index into of_file of each element, (elements, 1).
/// @param of_file    the file's regions; their names are their numbers.
/// @param box        of the surface [m].
void apply_regions(const std::vector<MaterialRegion>& regions, const fem::ElementMesh& mesh,
                   In<int32_t> region_of, const std::vector<AssetMaterial>& of_file,
                   const PlacedBox& box, Scene& scene, std::vector<Yield>& yields,
                   std::vector<std::string>& warnings);

}  // namespace elastogen
