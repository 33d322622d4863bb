// SPDX-License-Identifier: Apache-2.0
// The number of voxels that a surface needs, estimated from extents and areas before anything is
// allocated.

#pragma once

#include "io/weld.hpp"
#include "voxelize/voxelize.hpp"

namespace elastogen {

/// Upper estimate of the active voxels of edge h: the smaller of the box's cells and
/// volume / h^3 + sum over the triangles of min(cells of its box, 2 area / h^2 + 2 edges / h + 8).
/// An open surface may hold more than its signed volume tells.
double estimate_voxels(const WeldedMesh& mesh, double h);

/// @throws Error (resources) if the estimate exceeds max_voxels or max_memory; it names an h that
///         fits.
void check_budget(const WeldedMesh& mesh, double h, const VoxelizeOptions& options);

/// Checks a known number of voxels.
void check_budget(int64_t voxels, double h, const VoxelizeOptions& options);

}  // namespace elastogen
