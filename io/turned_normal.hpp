// SPDX-License-Identifier: Apache-2.0
// How the normals of points turn with the body.

#pragma once

#include <array>

namespace elastogen {

/// F^-T n as a unit vector, by the cofactors of F, which exist for every F; n itself where F does
/// not turn it.
/// @param F  row-major, 9 numbers.
std::array<float, 3> turned_normal(const double* F, const std::array<float, 3>& n);

}  // namespace elastogen
