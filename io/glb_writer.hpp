// SPDX-License-Identifier: Apache-2.0
// Animated GLB: morph targets whose weights play.

#pragma once

#include "io/animation_writer.hpp"

namespace elastogen {

/// A writer of GLB files. The asset's document is kept and gets, for each shown mesh, morph
/// targets (POSITION, and NORMAL where the mesh has normals) in the mesh's own numbers, one
/// animation of their weights, a root node if options.root is not the identity, and
/// asset.extras.elastogen with the certificates and the largest error of the targets. Nodes and
/// meshes are added as AnimatedDocument::stage says. Errors: see AnimationWriter.
std::unique_ptr<AnimationWriter> make_glb_writer(const std::string& path, const Asset& asset,
                                                 const Surface& surface,
                                                 const AnimationOptions& options);

}  // namespace elastogen
