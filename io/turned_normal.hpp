// SPDX-License-Identifier: Apache-2.0
// Normals of points that turn with the body.

#pragma once

#include <array>

namespace elastogen {

/// F^-T n as a unit vector, computed from the cofactors of F, which exist for every F; n itself if
/// that vector has no length.
/// @param F  row-major, 9 numbers.
std::array<float, 3> turned_normal(const double* F, const std::array<float, 3>& n);

}  // namespace elastogen
