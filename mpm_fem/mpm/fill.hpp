// SPDX-License-Identifier: Apache-2.0
// Particles that fill the voxels of a body.

#pragma once

#include "core/voxel_grid.hpp"
#include "mpm_fem/mpm/particles.hpp"

#include <functional>

namespace elastogen::mpm {

struct FillOptions {
  int per_edge = 2;   ///< particles of a full voxel along an axis: 8 of them
  double jitter = 1;  ///< share of a particle's part of the voxel over which it stands at
                      ///< random [-], 0 ... 1
  uint64_t seed = 1;
};

struct Filled {
  Particles particles;
  Array<int32_t> voxel;  ///< that each fills, (particles, 1)
};

/// Fills a body. A full voxel gets per_edge^3 particles, one in each of its equal parts; a partly
/// filled one gets its fill's share of them, one at least, in the parts next to the middle of its
/// fill. The particles of a voxel share phi h^3; if the grid has a volume all are scaled to it, so
/// that the mass is exact to rounding. The position of a particle depends on the seed and the
/// voxel's coordinates alone.
/// @param material  index into solids of each voxel, (voxels, 1)
/// @return particles with positions in the grid's coordinates less grid.origin [m]
Filled fill_body(const VoxelGrid& grid, In<int32_t> material, const std::vector<Solid>& solids,
                 const FillOptions& options = {});

/// Fills a part of the plane z = 0, a metre thick. Squares of edge h, with corners at multiples of
/// h, are cut into per_edge^2 parts; each part whose middle is inside gets a particle with its
/// volume.
/// @param lower, upper  of a box around the part that is filled [m]
Particles fill_plane(const Vec3& lower, const Vec3& upper, double h, const Solid& solid,
                     const std::function<bool(const Vec3&)>& inside,
                     const FillOptions& options = {});

}  // namespace elastogen::mpm
