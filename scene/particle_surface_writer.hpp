// SPDX-License-Identifier: Apache-2.0
// Surfaces and volumes of particles, one file a frame.

#pragma once

#include "io/animation_writer.hpp"
#include "scene/set_up.hpp"

namespace elastogen {

/// Whether an output is .obj, .mesh.ply or .vdb.
bool shows_surface(const std::string& path);

/// A writer of NAME_00000.obj, ... for a path NAME.obj; likewise for NAME.mesh.ply and NAME.vdb.
/// Each file is complete as soon as its frame has come, also without finish(). Meshes
/// (voxelize/particle_surface.hpp) are in the asset's own numbers and axes. If the asset has
/// colours, vertices have that of the nearest particle, in sRGB: OBJ `v x y z r g b`, PLY binary,
/// `red green blue`. Volumes are in metres (write_particle_vdb).
/// @param shown  the particles from shown_asset; it and the setup must outlive the writer.
/// @return null for another ending.
/// @throws Error (usage) from frame without a state of the particles for a .vdb; others as
///         AnimationWriter.
std::unique_ptr<AnimationWriter> make_particle_surface_writer(const std::string& path,
                                                              const Asset& shown,
                                                              const Setup& setup);

}  // namespace elastogen
