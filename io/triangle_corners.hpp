// SPDX-License-Identifier: Apache-2.0
// The corners of the triangles of a surface in their meshes, for attributes.

#pragma once

#include "io/asset.hpp"

namespace elastogen {

/// The corners of a triangle in its mesh.
struct TriangleCorners {
  const Mesh* mesh = nullptr;
  std::array<int32_t, 3> drawn = {};  ///< vertices of the mesh, in the order of the surface
};

/// Corners of all triangles of a posed surface, which reverses triangles of mirrored instances. The
/// asset must outlive them.
std::vector<TriangleCorners> triangle_corners(const Asset& asset, const Surface& surface);

}  // namespace elastogen
