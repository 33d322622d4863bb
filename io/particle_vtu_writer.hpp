// SPDX-License-Identifier: Apache-2.0
// Particles with strain and stress for ParaView: a PVD collection and one VTU file a frame.

#pragma once

#include "io/animation_writer.hpp"

namespace elastogen {

/// A writer of NAME.pvd, written by finish(), and of NAME_00000.vtu, ... beside it, each complete
/// as soon as its frame has come. Each particle is a vertex [m]. Appended raw data of points,
/// float32: `velocity` [m/s], `F` (9, row-major) and `J` of the elastic strain, `memory` (the
/// number that the law keeps), `kirchhoff_stress` [Pa] (xx yy zz xy yz xz), `mass` [kg], `volume`
/// at rest [m^3]; int32: `material`.
///
/// @throws Error (usage) without options.scene and options.particles, and from frame without state
///         and strain; others as AnimationWriter.
std::unique_ptr<AnimationWriter> make_particle_vtu_writer(const std::string& path,
                                                          const AnimationOptions& options);

}  // namespace elastogen
