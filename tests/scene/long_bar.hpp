// SPDX-License-Identifier: Apache-2.0
// A bar whose vertices are its eight corners.
#pragma once

#include "io/asset.hpp"

namespace elastogen {

/// A bar 1 x 0.2 x 0.2 m.
inline Asset long_bar() {
  Mesh mesh;
  for (int c = 0; c < 8; ++c) {
    mesh.position.push_back({double(c & 1), 0.2 * (c >> 1 & 1), 0.2 * (c >> 2)});
    mesh.position_of.push_back(c);
  }
  mesh.groups = {{0, {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                      2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5}}};
  Asset asset;
  asset.path = "bar.obj";
  asset.meshes = {mesh};
  asset.materials.resize(1);
  asset.nodes = {{"bar", -1, kIdentity4, 0}};
  return asset;
}

}  // namespace elastogen
