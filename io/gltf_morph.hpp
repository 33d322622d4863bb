// SPDX-License-Identifier: Apache-2.0
// Morph targets of a glTF document: the shape that their default weights show (glTF 2.0, 3.7.2.2).

#pragma once

#include "io/asset.hpp"
#include "io/gltf_edit.hpp"

#include <vector>

namespace elastogen {

/// Puts the simulated meshes into the shape of their weights (those of the node, else of the mesh),
///
///     x = X + sum_k w_k d_k
///
/// for every attribute that has targets; normals and tangents get the length one, tangents are made
/// orthogonal to the normals. Nodes that show a mesh with different weights get copies of it; nodes
/// that are not simulated keep theirs. Findings name the nodes that were changed ("morph-weights")
/// and count the meshes with targets, which the output will lack ("morph-targets").
/// @throws Error (asset) naming node or mesh: weights that are not finite or not as many as
///         targets, targets that are none, accessors of other lengths.
void bake_morph_weights(GltfEdit& edit, std::vector<Finding>& findings);

}  // namespace elastogen
