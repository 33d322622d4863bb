// SPDX-License-Identifier: Apache-2.0
// The triangle of the surface to which a voxel belongs: the nearest one.

#pragma once

#include "core/voxel_grid.hpp"
#include "voxelize/body.hpp"

namespace elastogen {

/// Squared distance of a point from a triangle [m^2]; also valid for triangles without area.
double triangle_distance2(const Vec3 corner[3], const Vec3& point);

/// Weights of the corners at the place of a triangle nearest to a point; equal weights if the
/// triangle has no area.
Vec3 nearest_weights(const Vec3 corner[3], const Vec3& point);

/// The triangle nearest to each voxel's centre, the first of several, (voxels, 1). A triangle that
/// faces the centre counts as farther by a millionth of its squared distance, so that voxels on
/// both sides of two touching solids belong to their own solid. If pieces are kept apart, each
/// voxel gets a triangle of its part. Any number of threads gives the same result.
/// @throws Error if the surface has no triangle.
Array<int32_t> nearest_triangles(const VoxelGrid& grid, const Surface& surface);

/// The part that carries each point, (points); empty if pieces are not kept apart. A vertex has the
/// part of its triangles, any other point that of the nearest triangle.
Array<int32_t> parts_of_carried(const Body& body);

}  // namespace elastogen
