// SPDX-License-Identifier: Apache-2.0
#include "core/bricks/links.hpp"

#include "core/parallel.hpp"

namespace elastogen {
namespace {

constexpr int64_t kAtOnce = 8;  // bricks of one task

/// Bricks at `base`, in bricks, plus offsets first, ..., first + count - 1 per axis, x fastest.
void find_block(const BrickIndex& index, const Coord& base, int first, int count, int32_t* found) {
  constexpr int32_t kLimit = kLatticeLimit / 8;
  const auto find = [&](const Coord& at) {
    for (const int32_t x : at)
      if (x < -kLimit || x >= kLimit) return index.brick_count();
    const int64_t brick = index.find_brick(brick_key({8 * at[0], 8 * at[1], 8 * at[2]}) >> 9);
    return brick < 0 ? index.brick_count() : brick;
  };
  for (int z = first; z < first + count; ++z)
    for (int y = first; y < first + count; ++y)
      for (int x = first; x < first + count; ++x)
        *found++ = int32_t(find({base[0] + x, base[1] + y, base[2] + z}));
}

void link_level(const BrickIndex* finer, BrickLevel& level, const BrickIndex* coarser) {
  level.node_brick.resize(size_t(level.voxels.brick_count()));
  for_each(
      level.voxels.brick_count(),
      [&](int64_t b) {
        const uint64_t key = brick_key(level.voxels.first_place(b)) >> 9;
        level.node_brick[size_t(b)] = int32_t(level.nodes.find_brick(key));
      },
      kAtOnce);
  level.links.resize(size_t(level.brick_count()));
  for_each(
      level.brick_count(),
      [&](int64_t b) {
        BrickLinks& links = level.links[size_t(b)] = {};
        Coord at = level.nodes.first_place(b);
        for (int32_t& x : at) x >>= 3;
        links.odd = (at[0] & 1) | (at[1] & 1) << 1 | (at[2] & 1) << 2;
        find_block(level.nodes, at, -1, 3, links.neighbour);
        const Coord parent = {(at[0] - 1) >> 1, (at[1] - 1) >> 1, (at[2] - 1) >> 1};
        if (coarser) find_block(*coarser, parent, 0, 2, links.coarse);
        if (finer) find_block(*finer, {2 * at[0], 2 * at[1], 2 * at[2]}, -1, 3, links.fine);
      },
      kAtOnce);
}

}  // namespace

void link_bricks(std::vector<BrickLevel>& levels) {
  for (size_t l = 0; l < levels.size(); ++l)
    link_level(l > 0 ? &levels[l - 1].nodes : nullptr, levels[l],
               l + 1 < levels.size() ? &levels[l + 1].nodes : nullptr);
}

}  // namespace elastogen
