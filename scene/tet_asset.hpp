// SPDX-License-Identifier: Apache-2.0
// A file of tetrahedra, or of triangles in the plane z = 0, for `simulate`: its surface as an
// asset, its elements as they are.

#pragma once

#include "io/asset.hpp"
#include "scene/description.hpp"

namespace elastogen {

/// Endings of files of tetrahedra; kReadFormats has those of assets.
inline constexpr const char* kTetFormats = " .msh .vtk .vtu";

struct TetAsset {
  Asset asset;                         ///< one mesh: the surface, in the file's numbers
  Array<int32_t> node_of;              ///< node of each position of the asset, (positions, 1)
  fem::ElementMesh mesh;               ///< kTet4, kTet10 or kTri3, in the file's numbers
  Array<int32_t> region;               ///< index into regions of each element, (elements, 1)
  std::vector<AssetMaterial> regions;  ///< regions, named by the file's numbers
};

/// Whether a path has one of these endings.
bool is_tet_file(const std::string& path);

/// Reads a file of tetrahedra; findings say what was turned or left out.
/// @throws Error (asset) as tets::read_tets, and for elements that fem::check_mesh refuses.
TetAsset read_tet_asset(const std::string& path);

/// The element for its steps: the file's, unless another one with as many nodes is asked for.
/// @throws Error (usage) naming the elements that fit.
fem::Element element_of(const TetAsset& tets, const FemOptions& options);

}  // namespace elastogen
