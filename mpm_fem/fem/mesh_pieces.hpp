// SPDX-License-Identifier: Apache-2.0
// Connected pieces of a mesh.

#pragma once

#include "mpm_fem/fem/element_mesh.hpp"

namespace elastogen::fem {

/// Piece of each node, (nodes, 1); elements that share a node belong to one piece. Numbered from 0
/// in the order of their first nodes; -1 at nodes of no element.
Array<int32_t> mesh_pieces(const ElementMesh& mesh);

}  // namespace elastogen::fem
