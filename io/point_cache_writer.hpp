// SPDX-License-Identifier: Apache-2.0
// Point cache (PC2): positions of every frame, for Blender's Mesh Cache modifier and others.

#pragma once

#include "io/animation_writer.hpp"

namespace elastogen {

/// A writer of PC2 files: "POINTCACHE2\0", int32 version 1, int32 points, float32 first frame 0,
/// float32 rate 1, int32 frames, then float32 x y z, little-endian, in the asset's own numbers,
/// axes and order (file_order). Errors: see AnimationWriter.
std::unique_ptr<AnimationWriter> make_point_cache_writer(const std::string& path,
                                                         const Asset& asset,
                                                         const Surface& surface);

}  // namespace elastogen
