// SPDX-License-Identifier: Apache-2.0
// Distance of two triangles.

#pragma once

#include "core/base.hpp"

namespace elastogen {

/// Smallest distance of a point of one triangle from a point of the other, squared; 0 where they
/// meet. Also for triangles without area.
double triangle_gap2(const Vec3 a[3], const Vec3 b[3]);

}  // namespace elastogen
