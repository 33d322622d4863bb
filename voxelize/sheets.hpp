// SPDX-License-Identifier: Apache-2.0
// Tells triangles that bound a solid from sheets and scraps, by what they bound, never by what
// touches them.

#pragma once

#include "voxelize/lattice_mesh.hpp"
#include "voxelize/mesh_edges.hpp"

namespace elastogen {

/// (b - a) x (c - a) / 2 of a triangle.
Vec3 area_vector(const LatticeMesh& mesh, size_t t);

/// Fills mesh.role and mesh.joint of each triangle and counts the sheets.
///
/// Pieces are triangles joined by edges of two faces. On a triangle that bounds a solid the winding
/// number of the whole surface (mean of both sides) is near 1/2, 3/2, ...; on one that bounds
/// nothing it is near a whole number. A piece looks like a sheet if it cannot be oriented, or if it
/// has a border loop longer than 2 sqrt(its area), however it is folded: a square sheet has 4, a
/// disc 3.5, half a sphere 2.5, a solid with a hole nearly 0. Such a piece is a sheet unless most
/// of its area bounds a solid together with other pieces, as triangles of a soup do. A piece is a
/// scrap if the winding number says that it bounds nothing and it is smaller than three voxels or
/// inside a solid.
/// @param conflicts  triangles at edges across which their piece cannot be oriented.
void find_sheets(LatticeMesh& mesh, const Edges& edges, const std::vector<int32_t>& conflicts);

}  // namespace elastogen
