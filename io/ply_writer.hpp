// SPDX-License-Identifier: Apache-2.0
// PLY sequences: one binary file a frame, for clouds, splats and meshes.

#pragma once

#include "io/animation_writer.hpp"

namespace elastogen {

/// A writer of NAME_00000.ply (the rest pose), NAME_00001.ply, ... for a path NAME.ply. Each file
/// is complete as soon as its frame has come, also without finish(). Binary, little-endian, float32
/// (positions float64 if is_float32_coarse), in the asset's own numbers, axes and order
/// (file_order):
///
/// - points: x y z, nx ny nz turned by F^-T, red green blue alpha (uchar) where the asset has them;
/// - splats: x y z nx ny nz f_dc_0..2 f_rest_0.. opacity scale_0..2 rot_0..3, with the logarithm of
///   the scale, the logit of the opacity, f_rest channel by channel, w first in rot, moved by
///   SplatMotion;
/// - particles: as points, then vx vy vz in the asset's numbers a second, J = det F of the elastic
///   strain, memory (the law's internal variable), material (int);
/// - meshes (PlyMesh): x y z, nx ny nz turned as normal_deltas says, s t, red green blue alpha and
///   the asset's own columns of vertices; triangles with texcoord, texnumber and colours where
///   corners or faces differ; comments TextureFile.
///
/// @throws Error (usage) from frame if a frame would overwrite the asset; others as
///         AnimationWriter.
std::unique_ptr<AnimationWriter> make_ply_writer(const std::string& path, const Asset& asset,
                                                 const Surface& surface,
                                                 const std::optional<ParticleSet>& particles = {});

}  // namespace elastogen
