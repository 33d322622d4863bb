// SPDX-License-Identifier: Apache-2.0
// Features that a grid cannot carry well: loose pieces and hinges.

#pragma once

#include "core/voxel_grid.hpp"
#include "io/asset.hpp"

#include <vector>

namespace elastogen {

/// Number of groups of voxels connected over faces, minus the number of pieces connected over
/// nodes. So many places hold by an edge or a corner alone and turn there without stiffness.
int64_t hinge_count(const VoxelGrid& grid);

/// Findings "loose-pieces" and "hinges" of a grid.
std::vector<Finding> check_grid(const VoxelGrid& grid);

}  // namespace elastogen
