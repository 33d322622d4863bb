// SPDX-License-Identifier: Apache-2.0
// Triangulation of the polygons of a file.

#pragma once

#include "core/base.hpp"

#include <vector>

namespace elastogen {

/// Largest polygon that is triangulated by ears; larger ones become fans.
inline constexpr int kMaxEarCorners = 256;
/// Largest polygon that readers accept.
inline constexpr int kMaxPolygonCorners = 1 << 16;

/// Triangles of a simple polygon in space, as triples of its corners, wound as the polygon: a fan
/// from the first corner where no triangle of it is turned over (in the coordinate plane nearest to
/// its Newell normal), else ears clipped in that plane. Always n - 2 triangles, none for n < 3.
std::vector<int> triangulate(const std::vector<Vec3>& corners);

}  // namespace elastogen
