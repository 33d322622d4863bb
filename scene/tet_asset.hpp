// SPDX-License-Identifier: Apache-2.0
// A file of tetrahedra, or of triangles in the plane z = 0, as what `simulate` animates: its surface
// as the asset, the rest as it is.

#pragma once

#include "io/asset.hpp"
#include "scene/description.hpp"

namespace elastogen {

/// Endings of the files that hold tetrahedra, as kReadFormats has those of assets.
inline constexpr const char* kTetFormats = " .msh .vtk .vtu";

struct TetAsset {
  Asset asset;                         ///< one mesh: the surface, in the file's numbers
  Array<int32_t> node_of;              ///< node of each of its positions, (positions, 1)
  fem::ElementMesh mesh;               ///< kTet4, kTet10 or kTri3, in the file's numbers
  Array<int32_t> region;               ///< index into regions of each element, (elements, 1)
  std::vector<AssetMaterial> regions;  ///< named by the file's numbers
};

/// Whether a name has one of those endings.
bool is_tet_file(const std::string& path);

/// Reads a file of tetrahedra; findings say what was turned or left out.
/// @throws Error (asset) as tets::read_tets, and for elements that fem::check_mesh refuses.
TetAsset read_tet_asset(const std::string& path);

/// The element that steps them: the file's, unless another of as many nodes is asked for.
/// @throws Error (usage) naming those that fit.
fem::Element element_of(const TetAsset& tets, const FemOptions& options);

}  // namespace elastogen
