// SPDX-License-Identifier: Apache-2.0
// Animated GLB: morph targets whose weights play.

#pragma once

#include "io/animation_writer.hpp"

namespace elastogen {

/// A writer of GLB files. It keeps the asset's document and adds, for each shown mesh, morph
/// targets (POSITION, and NORMAL if the mesh has normals) in the mesh's own numbers, one animation
/// of their weights, a root node unless options.root is the identity, and asset.extras.elastogen
/// with the certificates and the largest error of the targets. AnimatedDocument::stage says which
/// nodes and meshes are added. Errors: see AnimationWriter.
std::unique_ptr<AnimationWriter> make_glb_writer(const std::string& path, const Asset& asset,
                                                 const Surface& surface,
                                                 const AnimationOptions& options);

}  // namespace elastogen
