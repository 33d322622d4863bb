// SPDX-License-Identifier: Apache-2.0
// Which triangle of the surface a voxel belongs to: the nearest one.

#pragma once

#include "core/voxel_grid.hpp"
#include "voxelize/body.hpp"

namespace elastogen {

/// Distance of a point from a triangle, squared [m^2]; also for triangles without area.
double triangle_distance2(const Vec3 corner[3], const Vec3& point);

/// The triangle nearest to each voxel's centre, of several the first, (voxels, 1). A triangle that
/// faces the centre counts as farther by a millionth of its squared distance: where two solids
/// touch, each voxel goes with its own. Where pieces are kept apart, each voxel takes one of its
/// part. Same result on any number of threads.
/// @throws Error if the surface has no triangle.
Array<int32_t> nearest_triangles(const VoxelGrid& grid, const Surface& surface);

/// The part that each carried point goes with, (points); empty where pieces are not kept apart. A
/// vertex goes with its triangles, another point with the nearest one.
Array<int32_t> parts_of_carried(const Body& body);

}  // namespace elastogen
