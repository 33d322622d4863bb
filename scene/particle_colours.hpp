// SPDX-License-Identifier: Apache-2.0
// The colours that particles take from the asset.

#pragma once

#include "scene/set_up.hpp"

namespace elastogen {

/// Colour, linear, and alpha of each particle: of a mesh that of the nearest place on the triangle
/// that is nearest to its voxel, texture times base colour times colours of vertices; of a cloud
/// that of the nearest point; of splats the first harmonic of the nearest that is not transparent.
/// Empty where the asset has no colours.
/// @param carried  vertices, points or splats of the asset [m], (points, 3).
/// @param notes    gets a sentence for each texture that cannot be shown.
std::vector<std::array<float, 4>> particle_colours(const Asset& asset, const Setup& setup,
                                                   const ParticleSetup& particles,
                                                   In<double> carried,
                                                   std::vector<std::string>& notes);

}  // namespace elastogen
