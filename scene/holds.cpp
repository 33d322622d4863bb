// SPDX-License-Identifier: Apache-2.0
#include "scene/holds.hpp"

#include "core/error.hpp"
#include "scene/pins.hpp"
#include "voxelize/border.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace elastogen {
namespace {

std::string option_of(const Hold& hold) {
  return fmt::format("--hold '{}'", hold.text);
}

/// Says that only nodes are held where a border cuts voxels.
void say_cut(const Hold& hold, Setup& setup) {
  const PlacedBox& box = setup.body.surface.box;
  const std::optional<Border> border = border_of(hold.selection, box);
  if (setup.tets || fits_grid(border, setup) || !reaches(*border, box)) return;
  setup.warnings.push_back(fmt::format(
      "{}: its border cuts voxels, of which only the nodes in it are held along these axes",
      option_of(hold)));
}

/// Fixes the axes of a hold at a node unless it is held already.
void fix_node(int64_t n, const Hold& hold, int32_t holder, Scene& scene) {
  const int32_t before = scene.holder(n);
  if (before >= 0 && scene.holders[size_t(before)].moves())
    throw Error(fmt::format(
        "{} and {} contradict each other: both have the node at ({:.4g}, {:.4g}, {:.4g}) m",
        scene.holders[size_t(holder)].name, scene.holders[size_t(before)].name,
        scene.grid.rest(n, 0), scene.grid.rest(n, 1), scene.grid.rest(n, 2)));
  for (int d = 0; d < 3; ++d)
    if (hold.axes[size_t(d)] && scene.pinned(n) == kFreeNode && scene.fixed(n, d) < 0)
      scene.fixed(n, d) = holder;
}

}  // namespace

void fix_axes(const RunDescription& run, Setup& setup) {
  Scene& scene = setup.scene;
  const bool holds_axes = run.fem || method_of(run) == Method::kAuto;
  if (holds_axes && !run.holds.empty()) {
    scene.fixed = Array<int32_t>(scene.grid.node_count(), 3);
    scene.fixed.fill(-1);
  }
  for (const Hold& hold : run.holds) {
    const Array<uint8_t> nodes = held_nodes(option_of(hold), hold.selection, setup);
    say_cut(hold, setup);
    if (!holds_axes) continue;
    const auto holder = int32_t(scene.holders.size());
    scene.holders.emplace_back().name = option_of(hold);
    for (int64_t n = 0; n < nodes.rows(); ++n)
      if (nodes(n)) fix_node(n, hold, holder, scene);
  }
}

}  // namespace elastogen
