// SPDX-License-Identifier: Apache-2.0
// What borders leave free of a body: voxels, fill, and integrals of the shape functions over it.

#pragma once

#include "voxelize/border.hpp"
#include "voxelize/cut_body.hpp"

namespace elastogen {

/// A voxel of a body in which a part is held and another part is free.
struct CutVoxel {
  Coord coord;
  double share = 0;              ///< free, of the voxel
  double moment[8] = {};         ///< integrals of the shape functions over the free part
  Vec3 thickness = {1, 1, 1};    ///< mean length of the free part along each axis [voxel edges]
  std::vector<int32_t> borders;  ///< that hold something in it
};

struct FreePart {
  Array<int32_t> voxels;      ///< those with free material, (voxels, 3)
  std::vector<CutVoxel> cut;  ///< those of them in which something is held
  double held = 0;            ///< volume behind the borders [voxels]
};

/// The free part of a body. The integrals over what a body fills of a voxel are multiplied by the
/// share of each that borders leave (voxelize/held_share.hpp): exact in full voxels, and in any where
/// faces of the body stand across the axes, but for balls.
FreePart free_part(const CutBody& body, const std::vector<Border>& borders);

/// 1 for each surface cell of a body that free_part would cut, (cells); empty without borders.
std::vector<uint8_t> cut_cells(const CutBody& body, const std::vector<Border>& borders);

}  // namespace elastogen
