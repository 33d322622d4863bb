// SPDX-License-Identifier: Apache-2.0
#include "network/mesh_number/coarse_scene.hpp"

#include "core/parallel.hpp"

#include <algorithm>

namespace elastogen {
namespace {

/// Index of the material of a voxel's heaviest child.
int32_t heaviest(const Scene& fine, const int32_t* children) {
  std::vector<double> mass(fine.materials.size());
  for (int c = 0; c < 8; ++c) {
    if (children[c] < 0) continue;
    const auto m = size_t(fine.material(children[c]));
    mass[m] += fine.grid.fill(children[c]) * fine.materials[m].density;
  }
  return int32_t(std::max_element(mass.begin(), mass.end()) - mass.begin());
}

Array<uint8_t> fixed_nodes(const CoarseGrid& coarse, const Array<uint8_t>& fine) {
  Array<double> is_fixed(fine.rows(), 4);  // the last column counts all nodes
  for_each(fine.rows(), [&](int64_t n) {
    for (int i = 0; i < 3; ++i) is_fixed(n, i) = fine(n, i);
    is_fixed(n, 3) = 1;
  });
  const int64_t nodes = coarse.around.rows();
  Array<double> share(nodes, 4);
  restrict_sum(coarse, 4, is_fixed.data(), share.data());
  Array<uint8_t> fixed(nodes, 3);
  for_each(nodes, [&](int64_t n) {
    const int32_t same = coarse.around(n, kSamePlace);
    for (int i = 0; i < 3; ++i)
      fixed(n, i) = same >= 0 ? fine(same, i) : share(n, i) > share(n, 3) / 2;
  });
  return fixed;
}

}  // namespace

CoarseScene coarse_scene(const Scene& fine, const Array<uint8_t>& fixed, double dt) {
  // grid
  Array<uint8_t> held(fine.grid.node_count());
  for_each(held.rows(), [&](int64_t n) { held(n) = fixed(n, 0) | fixed(n, 1) | fixed(n, 2); });
  CoarseScene coarse;
  coarse.transfer = coarse_grid(fine.grid, held);
  coarse.fit = NodeFit(coarse.transfer, fine.grid);
  Scene& scene = coarse.scene;
  scene.grid = std::move(coarse.transfer.grid);
  // materials
  scene.materials = fine.materials;
  scene.material = Array<int32_t>(scene.grid.voxel_count());
  for_each(scene.grid.voxel_count(),
           [&](int64_t v) { scene.material(v) = heaviest(fine, coarse.transfer.children.row(v)); });
  // what is held
  coarse.fixed = fixed_nodes(coarse.transfer, fixed);
  scene.pinned = Array<uint8_t>(scene.grid.node_count());
  for (int64_t n = 0; n < scene.grid.node_count(); ++n) {
    const uint8_t* f = coarse.fixed.row(n);
    scene.pinned(n) = f[0] & f[1] & f[2];
    coarse.has_rails |= (f[0] | f[1] | f[2]) != scene.pinned(n);
  }
  // time step, weights, and the masses of h
  scene.dt = dt;
  scene.scheme = TimeScheme::kBdf2;
  scene.hourglass = fine.hourglass;
  finish_scene(scene);
  restrict_sum(coarse.transfer, 1, fine.mass.data(), scene.mass.data());
  return coarse;
}

}  // namespace elastogen
