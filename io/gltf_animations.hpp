// SPDX-License-Identifier: Apache-2.0
// Animations of a glTF document that are kept beside the simulated one.

#pragma once

#include "io/asset.hpp"
#include "io/gltf_edit.hpp"

namespace elastogen {

/// Channels of all animations of a document.
int64_t count_channels(const GltfEdit::Json& document);

/// Keeps only channels that move what is not simulated: channels of nodes that neither show a mesh
/// of the asset nor have one below them, and channels that move no node (of materials, by
/// KHR_animation_pointer). Removes channels that name no node, sampler or accessor of the document,
/// then samplers and animations that nothing uses.
/// @param nodes  nodes of the asset; node i is node i of the document.
void keep_other_animations(GltfEdit::Json& document, const std::vector<AssetNode>& nodes);

/// Removes the channels of joints, as their motion is in the pose already; except joints that have
/// a mesh, camera or lamp below them.
void remove_joint_channels(GltfEdit::Json& document);

}  // namespace elastogen
