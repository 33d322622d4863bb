// SPDX-License-Identifier: Apache-2.0
// Polygons of a file to triangles.

#pragma once

#include "core/base.hpp"

#include <vector>

namespace elastogen {

/// Largest polygon that is searched for ears; larger ones become fans.
inline constexpr int kMaxEarCorners = 256;
/// Largest polygon that readers take.
inline constexpr int kMaxPolygonCorners = 1 << 16;

/// Triangles of a simple polygon in space, as triples of its corners, wound as the polygon: a fan
/// from the first corner where no triangle of it is turned over (in the coordinate plane nearest to
/// its Newell normal), else ears clipped in that plane. Always n - 2 triangles, none for n < 3.
std::vector<int> triangulate(const std::vector<Vec3>& corners);

}  // namespace elastogen
