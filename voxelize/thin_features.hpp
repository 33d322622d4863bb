// SPDX-License-Identifier: Apache-2.0
// What a grid cannot carry well: loose pieces and hinges.

#pragma once

#include "core/voxel_grid.hpp"
#include "io/asset.hpp"

#include <vector>

namespace elastogen {

/// Groups of voxels connected over faces, less the pieces connected over nodes: so many places are
/// held by an edge or a corner alone and turn there without stiffness.
int64_t hinge_count(const VoxelGrid& grid);

/// Findings "loose-pieces" and "hinges" of a grid.
std::vector<Finding> check_grid(const VoxelGrid& grid);

}  // namespace elastogen
