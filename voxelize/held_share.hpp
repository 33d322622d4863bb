// SPDX-License-Identifier: Apache-2.0
// What borders leave free of what a body fills in one voxel, in whose coordinates (0..1 along each
// edge) everything here is.

#pragma once

#include "voxelize/border.hpp"
#include "voxelize/cell_lines.hpp"

namespace elastogen {

/// Shares of the integrals of the shape functions over a box that borders leave, (8): exact for
/// boxes and half spaces, with balls means over 8^3 points.
void free_shares(const Box& box, const std::vector<Border>& borders, double free[8]);

/// The same over what a surface fills of the box, by 8 x 8 lines; exact where faces of the surface
/// and of the borders stand across the axes. Shares of integrals that no line finds stay as they are.
/// @param of_body  these integrals, (8); they tell the inside of the surface from its outside.
/// @return the mean length of what is left along lines of each axis; all of the body's share where no
///         line finds any.
Vec3 free_shares_inside(const LocalTriangles& surface, const double of_body[8], const Box& box,
                        const std::vector<Border>& borders, double free[8]);

}  // namespace elastogen
