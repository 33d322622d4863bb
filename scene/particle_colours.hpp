// SPDX-License-Identifier: Apache-2.0
// The colours of particles, taken over from the asset.

#pragma once

#include "scene/set_up.hpp"

namespace elastogen {

/// Linear colour and alpha of each particle. For a mesh: the colour at the nearest place of the
/// triangle that is nearest to the particle's voxel, texture times base colour times colours of
/// vertices. For a cloud: the nearest point's colour. For splats: the first harmonic of the nearest
/// one that is not transparent. Empty if the asset has no colours.
/// @param carried  vertices, points or splats of the asset [m], (points, 3).
/// @param notes    gets a sentence for each texture that cannot be shown.
std::vector<std::array<float, 4>> particle_colours(const Asset& asset, const Setup& setup,
                                                   const ParticleSetup& particles,
                                                   In<double> carried,
                                                   std::vector<std::string>& notes);

}  // namespace elastogen
