// SPDX-License-Identifier: Apache-2.0
// Tetrahedra from hexahedra and from tetrahedra: voxels cut into five or six, the nodes of
// quadratic elements, uniform refinement.

#pragma once

#include "mpm_fem/fem/element_mesh.hpp"

namespace elastogen::fem {

/// kFive: one in the middle and four at the corners, mirrored from voxel to voxel, so that faces
/// conform. kSix: around the diagonal from corner 0 to 7, equal in all voxels (Kuhn 1960).
enum class VoxelSplit : uint8_t { kFive, kSix };

/// The voxels of a finished scene as kTet4 on the same nodes; tetrahedra 5 v ... or 6 v ... are
/// those of voxel v and have its material and fill.
/// @throws Error if the scene has no voxels or no material for each.
ElementMesh voxel_tets(const Scene& scene, VoxelSplit split);

/// The six tetrahedra of each hexahedron around its diagonal from corner 0 to 7. Faces conform
/// where neighbours number their corners alike.
/// @param hexahedra  node of each corner in the order of VoxelGrid, (hexahedra, 8)
/// @return           node of each corner, (6 hexahedra, 4)
Array<int32_t> kuhn_tets(In<int32_t> hexahedra);

/// The tetrahedra as kTet10 with straight edges: nodes keep their numbers, and one node in the
/// middle of each edge comes after them.
/// @throws Error unless the mesh is kTet4 with its nodes in range.
ElementMesh quadratic(const ElementMesh& mesh);

/// Each tetrahedron cut into eight of an eighth of its volume, 8 e ... 8 e + 7: four at its corners
/// and four around the shortest diagonal of the octahedron between them (Zhang 1995), so that
/// refining again and again leaves no slivers. Nodes keep their numbers.
/// @throws Error as quadratic.
ElementMesh refined(const ElementMesh& mesh);

}  // namespace elastogen::fem
