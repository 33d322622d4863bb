// SPDX-License-Identifier: Apache-2.0
// The animations of a glTF document beside the simulated one.

#pragma once

#include "io/asset.hpp"
#include "io/gltf_edit.hpp"

namespace elastogen {

/// Channels of all animations of a document.
int64_t count_channels(const GltfEdit::Json& document);

/// Leaves the channels that move what is not simulated: those of nodes that neither show a mesh of
/// the asset nor have one below them, and those that move no node (of materials, by
/// KHR_animation_pointer). Channels that name no node, sampler or accessor of the document go too,
/// with them samplers and animations that nothing uses.
/// @param nodes  of the asset; node i is node i of the document.
void keep_other_animations(GltfEdit::Json& document, const std::vector<AssetNode>& nodes);

/// Takes the channels of joints out, for what they moved is posed; but for joints that have a mesh,
/// camera or lamp below them.
void remove_joint_channels(GltfEdit::Json& document);

}  // namespace elastogen
