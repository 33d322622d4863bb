// SPDX-License-Identifier: Apache-2.0
// A cube as an asset.

#pragma once

#include "io/asset.hpp"

namespace elastogen::test {

/// Cube of edge a with its lower corner at o, outside out.
inline Asset cube(double a = 1, const Vec3& o = {}) {
  Asset asset;
  asset.path = "cube";
  asset.format = "obj";
  Mesh& mesh = asset.meshes.emplace_back();
  mesh.name = "box";
  for (int c = 0; c < 8; ++c) {
    mesh.position.push_back({o[0] + a * (c & 1), o[1] + a * (c >> 1 & 1), o[2] + a * (c >> 2)});
    mesh.position_of.push_back(c);
  }
  mesh.groups.push_back({-1,
                         {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                          2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5},
                         -1});
  asset.nodes.push_back({"box", -1, kIdentity4, 0});
  return asset;
}

/// Corners of its only group of triangles.
inline std::vector<int32_t>& corners(Asset& asset) {
  return asset.meshes[0].groups[0].corner;
}

}  // namespace elastogen::test
