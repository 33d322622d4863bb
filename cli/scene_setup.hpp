// SPDX-License-Identifier: Apache-2.0
// From an asset and the options of a run to a finished scene.

#pragma once

#include "cli/options.hpp"
#include "cli/tet_asset.hpp"
#include "io/asset.hpp"
#include "io/report_file.hpp"
#include "voxelize/body.hpp"

#include <functional>
#include <optional>

namespace elastogen {

struct Setup {
  Body body;
  Scene scene;
  /// Tetrahedra that are stepped as the file has them [m]; the scene's grid then has only their
  /// nodes as rest, and mean_edge as h.
  std::optional<fem::ElementMesh> tets;
  Array<int32_t> node_of;  ///< with tets: node of each carried point, (points, 1)
  int substeps = 1;
  double longest_edge = 0;                       ///< of the asset [m]
  double sheet_volume = 0, sheet_thickness = 0;  ///< of sheets and shells [m^3], [m]
  UpAxis up;
};

/// Poses, voxelises and pins the asset; fills asset, voxels, materials, warnings and times of the
/// report.
/// @param materials, regions  materials and the one of each voxel; empty: that of the options.
Setup set_up(const Asset& asset, const AnimateOptions& options,
             const std::vector<Material>& materials,
             const std::function<Array<int32_t>(const VoxelGrid&)>& regions, RunReport& report);

/// The same of a mesh of tetrahedra, which is neither voxelised nor cut.
/// @throws Error (usage) where --element is of another kind than the file's.
Setup set_up(const TetAsset& tets, const AnimateOptions& options, RunReport& report);

/// What will be computed, in a few lines: size, up, grid, material, time step, numerical damping.
void print_setup(const Setup& setup, const AssetSummary& asset, const AnimateOptions& options);

}  // namespace elastogen
