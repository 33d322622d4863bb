// SPDX-License-Identifier: Apache-2.0
#include "network/precondition/smooth_modes.hpp"

#include "core/parallel.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace elastogen {

std::vector<Wave> lowest_waves(const Box& box, int count) {
  std::vector<std::pair<double, Wave>> waves;
  const auto frequency = [&](int k, int d) {
    const double length = box.extent(d);
    if (k == 0) return 0.0;
    return length > 0 ? k * k / (length * length) : 1e300;
  };
  for (int x = 0; x < count; ++x)
    for (int y = 0; y < count; ++y)
      for (int z = 0; z < count; ++z)
        if ((x + 1) * (y + 1) * (z + 1) <= count)  // no other can be among the lowest
          waves.push_back({frequency(x, 0) + frequency(y, 1) + frequency(z, 2), {x, y, z}});
  std::sort(waves.begin(), waves.end());
  std::vector<Wave> result;
  for (int k = 0; k < count; ++k) result.push_back(waves[size_t(k)].second);
  return result;
}

namespace {

LatticePlace place_of(const VoxelGrid& grid, int64_t node) {
  return {{grid.node_coord(node, 0), grid.node_coord(node, 1), grid.node_coord(node, 2)}};
}

/// Whether a pin has pins all around it: one of them is nearer to any other node.
bool is_inner_pin(const Scene& scene, int64_t node) {
  for (int c = 0; c < 8; ++c) {
    const int32_t v = scene.grid.voxels(node, c);
    if (v < 0) return false;
    for (int e = 0; e < 8; ++e)
      if (!scene.pinned(scene.grid.corners(v, e))) return false;
  }
  return true;
}

/// Extends box k of a list by a box; k may be the next new one.
void add(size_t k, const LatticeBox& box, std::vector<LatticeBox>& to) {
  if (k == to.size())
    to.push_back(box);
  else
    to[k].add(box);
}

}  // namespace

LatticeBox lattice_box(const VoxelGrid& grid, const std::vector<int32_t>& nodes) {
  const auto count = int64_t(nodes.size());
  if (count == 0) return {{}, {{-1, -1, -1}}};
  const LatticePlace first = place_of(grid, nodes[0]);
  std::vector<LatticeBox> boxes(size_t((count + kBlock - 1) / kBlock), {first, first});
  for_each(count, [&](int64_t k) {
    const LatticePlace at = place_of(grid, nodes[size_t(k)]);
    boxes[size_t(k / kBlock)].add({at, at});
  });
  for (const LatticeBox& box : boxes) boxes[0].add(box);
  return boxes[0];
}

PlaneCosines::PlaneCosines(double h, const LatticeBox& planes, const std::vector<Wave>& waves,
                           const Box& box)
    : first_(planes.lower), waves_(int(waves.size())) {
  for (int d = 0; d < 3; ++d)
    for (int32_t plane = first_.at[d]; plane <= planes.upper.at[d]; ++plane)
      for (const Wave& wave : waves) {
        const double share =
            wave[size_t(d)] > 0 ? double(plane - first_.at[d]) * h / box.extent(d) : 0;
        table_[d].push_back(std::cos(std::numbers::pi * wave[size_t(d)] * share));
      }
}

PinTrees::PinTrees(const Scene& scene) : trees(size_t(scene.grid.pieces)) {
  const VoxelGrid& grid = scene.grid;
  // outer pins of each piece
  const std::vector<int32_t> pins = filtered(
      grid.node_count(), [&](int64_t n) { return scene.pinned(n) && !is_inner_pin(scene, n); });
  std::vector<std::vector<LatticePlace>> of_piece(trees.size());
  for (const int32_t n : pins) of_piece[size_t(grid.piece(n))].push_back(place_of(grid, n));
  for (size_t piece = 0; piece < trees.size(); ++piece) {
    const std::vector<LatticePlace>& own = of_piece[piece];
    PinTree& tree = trees[piece];
    tree.first = int32_t(places.size());
    tree.count = int32_t(own.size());
    places.insert(places.end(), own.begin(), own.end());
    // the lowest level, then pairs of boxes until one is left
    std::vector<LatticeBox> level;
    for (size_t k = 0; k < own.size(); ++k) add(k / PinTree::kLeaf, {own[k], own[k]}, level);
    while (!level.empty()) {
      tree.begin[tree.levels] = int32_t(boxes.size());
      tree.boxes[tree.levels++] = int32_t(level.size());
      boxes.insert(boxes.end(), level.begin(), level.end());
      if (level.size() == 1) break;
      std::vector<LatticeBox> pairs;
      for (size_t k = 0; k < level.size(); ++k) add(k / 2, level[k], pairs);
      level = std::move(pairs);
    }
  }
}

Zeroed<double> pin_distance(const Scene& scene, const PinTrees& pins,
                            const std::vector<int32_t>& nodes) {
  const VoxelGrid& grid = scene.grid;
  const PinTreesView trees = pins.view();
  Zeroed<double> distance(nodes.size());
  for_blocks(int64_t(nodes.size()), [&](int64_t begin, int64_t end) {
    int32_t piece = -1;
    LatticePlace pin = {};
    for (int64_t k = begin; k < end; ++k) {
      const int32_t n = nodes[size_t(k)];
      const PinTree& tree = pins.trees[size_t(grid.piece(n))];
      if (tree.count == 0) {
        distance[size_t(k)] = 1e300;
        continue;
      }
      const LatticePlace at = place_of(grid, n);
      // the pin of the node before is a good first guess
      if (piece != grid.piece(n)) piece = grid.piece(n), pin = pins.places[size_t(tree.first)];
      pin = scene.pinned(n) ? at : trees.nearest(piece, at, pin);
      distance[size_t(k)] = grid.h * std::sqrt(double(square_between(at, pin)));
    }
  });
  return distance;
}

}  // namespace elastogen
