// SPDX-License-Identifier: Apache-2.0
// From an asset and the options of a run to a finished scene.

#pragma once

#include "cli/options.hpp"
#include "io/asset.hpp"
#include "io/report_file.hpp"
#include "voxelize/body.hpp"

#include <functional>

namespace elastogen {

struct Setup {
  Body body;
  Scene scene;
  int substeps = 1;
  double longest_edge = 0;  ///< of the asset [m]
  UpAxis up;
};

/// Poses, voxelises and pins the asset; fills asset, voxels, materials, warnings and times of the
/// report.
/// @param materials, regions  materials and the one of each voxel; empty: that of the options.
Setup set_up(const Asset& asset, const AnimateOptions& options,
             const std::vector<Material>& materials,
             const std::function<Array<int32_t>(const VoxelGrid&)>& regions, RunReport& report);

/// What will be computed, in a few lines: size, up, grid, material, time step, numerical damping.
void print_setup(const Setup& setup, const AssetSummary& asset, const AnimateOptions& options);

/// Why an animation without motion has none.
std::string nothing_moved(const Scene& scene, const AnimateOptions& options);

}  // namespace elastogen
