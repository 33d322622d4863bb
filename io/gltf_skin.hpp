// SPDX-License-Identifier: Apache-2.0
// Linear blend skinning: a skinned mesh in the pose that its joints have (glTF 2.0, 3.7.3).

#pragma once

#include "io/asset.hpp"
#include "io/gltf_edit.hpp"

#include <vector>

namespace elastogen {

/// Puts every skinned mesh of the default scene into its pose,
///
///     x = sum_j w_j W_j B_j X / sum_j w_j,
///
/// with W_j the world matrix of joint j and B_j its inverse bind matrix; normals and tangents turn
/// with it. In glTF the matrix of the node that shows the mesh has no part in this. The posed mesh
/// therefore stands on a new node at the root, behind the others. A vertex without weights follows
/// its first joint. Skins, joints and weights are removed from the document.
/// @throws Error (asset) naming the node or accessor: no such skin or joint, a joint index out of
///         range, weights that are negative or not finite, accessors of different lengths.
void pose_skins(GltfEdit& edit, std::vector<Finding>& findings);

}  // namespace elastogen
