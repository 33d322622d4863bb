// SPDX-License-Identifier: Apache-2.0
// The character of `elastogen demo`: an asset made here, so that nothing has to be downloaded.

#pragma once

#include "core/voxel_grid.hpp"
#include "io/asset.hpp"

namespace elastogen {

/// A friendly figure one metre tall that stands on y = 0 and looks along +z: a closed mesh of balls
/// and limbs, blended as level sets, with normals, uv (one seam at the back), colours, and the
/// materials "body" and "head" (with the antennae). Every call gives the same bits.
Asset demo_character();

/// Physical material of each voxel of the character's grid, (voxels, 1): 0 body, 1 head.
Array<int32_t> demo_regions(const VoxelGrid& grid);

}  // namespace elastogen
