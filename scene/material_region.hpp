// SPDX-License-Identifier: Apache-2.0
// The material of a part of the asset, as text and as values.

#pragma once

#include "mpm_fem/fem/element_mesh.hpp"
#include "mpm_fem/materials/solid.hpp"
#include "voxelize/regions.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace elastogen {

struct AssetPart;

struct MaterialRegion {
  std::string text;     ///< as it was typed, for messages
  Selection selection;  ///< a place selects voxels by their centres
  Material material;
  Yield yield = {};
};

/// Reads 'SELECTION: MATERIAL'. MATERIAL is a preset, optionally with changes: ,young=2MPa
/// ,poisson=0.4 ,density=900 ,law=stvk, and those of change_solid.
/// @throws Error (usage) naming the text and what is wrong.
MaterialRegion parse_region(std::string_view text);

/// Gives the voxels of each region its material; later regions override earlier ones. Materials
/// that no voxel has in the end are dropped.
/// @param parts     of the asset, those of the regions among them.
/// @param box       of the surface [m].
/// @param scene     with grid, materials, and the material of each voxel.
/// @param yields    of each material.
/// @param warnings  gets a sentence for each region that holds no voxel.
void apply_regions(const std::vector<MaterialRegion>& regions, const std::vector<AssetPart>& parts,
                   const PlacedBox& box, Scene& scene, std::vector<Yield>& yields,
                   std::vector<std::string>& warnings);

/// Gives the tetrahedra of each region its material; places select centroids.
void apply_regions(const std::vector<MaterialRegion>& regions, const std::vector<AssetPart>& parts,
                   const fem::ElementMesh& mesh, const PlacedBox& box, Scene& scene,
                   std::vector<Yield>& yields, std::vector<std::string>& warnings);

}  // namespace elastogen
