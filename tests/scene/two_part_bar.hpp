// SPDX-License-Identifier: Apache-2.0
// A bar whose first fifth is a node, a material and a group of painted vertices of its own.
#pragma once

#include "io/asset.hpp"

namespace elastogen {

/// The sides of a bar between places along x, and the caps at 0 and 1 m. Triangles up to 0.2 m have
/// material 0, others 1.
inline Mesh sleeve(const std::vector<double>& places) {
  Mesh mesh;
  mesh.groups.resize(2);
  mesh.groups[1].material = 1, mesh.groups[0].material = 0;
  for (const double x : places)
    for (int c = 0; c < 4; ++c) {
      mesh.position_of.push_back(int32_t(mesh.position.size()));
      mesh.position.push_back({x, 0.2 * (c & 1), 0.2 * (c >> 1)});
    }
  const auto quad = [&](size_t ring, bool held, int a, int b, int c, int d) {
    for (const int k : {a, b, c, a, c, d})
      mesh.groups[held ? 0 : 1].corner.push_back(int32_t(4 * ring) + k);
  };
  for (size_t r = 0; r < places.size(); ++r) {
    const double x = places[r];
    if (x == 0) quad(r, true, 0, 1, 3, 2);
    if (x == 1) quad(r, false, 0, 2, 3, 1);
    if (r + 1 == places.size()) break;
    const bool held = x < 0.1;
    quad(r, held, 0, 4, 5, 1), quad(r, held, 1, 5, 7, 3);
    quad(r, held, 3, 7, 6, 2), quad(r, held, 2, 6, 4, 0);
  }
  return mesh;
}

/// A bar 1 x 0.2 x 0.2 m in one mesh, or in two that share no vertex: nodes "grip" (up to x = 0.2 m)
/// and "rest". Materials likewise. Vertices up to 0.2 m are red and have w = 1, the others are blue
/// and have w = 0.
inline Asset two_part_bar(bool two_meshes) {
  Asset asset;
  asset.path = "bar.glb";
  asset.materials.resize(2);
  asset.materials[0].name = "Rubber grip";
  asset.materials[1].name = "Wood";
  if (two_meshes) {
    asset.meshes = {sleeve({0, 0.2}), sleeve({0.2, 1})};
    asset.nodes = {
        {"hand", -1, kIdentity4, -1}, {"grip", 0, kIdentity4, 0}, {"rest", -1, kIdentity4, 1}};
  } else {
    asset.meshes = {sleeve({0, 0.2, 1})};
    asset.nodes = {{"bar", -1, kIdentity4, 0}};
  }
  for (Mesh& mesh : asset.meshes) {
    mesh.attributes = {{"_W", {}, {}}};
    for (const Vec3& x : mesh.position) {
      const bool held = x[0] < 0.3;
      mesh.colour.push_back({float(held), 0, float(!held), 1});
      mesh.attributes[0].value.push_back(held);
    }
  }
  return asset;
}

}  // namespace elastogen
