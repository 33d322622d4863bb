// SPDX-License-Identifier: Apache-2.0
// The rules by which slivers go, once more: on ordered maps, by searches over lists.

#pragma once

#include "voxelize/bricks.hpp"
#include "voxelize/cut_body.hpp"
#include "voxelize/thin_features.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <set>
#include <tuple>

namespace elastogen::test {

using Fills = std::map<Coord, double>;

/// Sum of the coordinates' differences; more than 3 where two voxels share no node.
inline int distance(const Coord& a, const Coord& b) {
  int sum = 0;
  for (int d = 0; d < 3; ++d) sum += std::abs(a[d] - b[d]) > 1 ? 4 : std::abs(a[d] - b[d]);
  return sum;
}

/// Groups of voxels of which each is joined to the next over at most `axes` axes; counts those
/// that have a voxel of `part`.
inline int groups_of(const std::vector<Coord>& part, const std::vector<Coord>& all, int axes) {
  int groups = 0;
  std::set<Coord> seen;
  for (const Coord& first : part) {
    if (!seen.insert(first).second) continue;
    ++groups;
    std::vector<Coord> stack = {first};
    while (!stack.empty()) {
      const Coord at = stack.back();
      stack.pop_back();
      for (const Coord& other : all)
        if (distance(at, other) <= axes && seen.insert(other).second) stack.push_back(other);
    }
  }
  return groups;
}

/// The voxels in the block around one, without it, that pass a test.
template <class Passes>
std::vector<Coord> neighbours(const Fills& fills, const Coord& voxel, const Passes& passes) {
  std::vector<Coord> result;
  for (int i = 0; i < 27; ++i) {
    const Coord other = {voxel[0] + i % 3 - 1, voxel[1] + i / 3 % 3 - 1, voxel[2] + i / 9 - 1};
    if (other != voxel && fills.count(other) && passes(other)) result.push_back(other);
  }
  return result;
}

/// The voxels that count as slivers at the start of a round.
inline std::set<Coord> slivers_of(const Fills& fills) {
  std::set<Coord> result;
  for (const auto& [coord, fill] : fills) {
    const auto& at = coord;
    const auto faces = neighbours(fills, at, [&](auto& other) { return distance(at, other) == 1; });
    const auto thick = neighbours(fills, at, [&](auto& other) { return fills.at(other) >= 0.1; });
    if (fill < 0.02 || (fill < 0.1 && faces.size() <= 1 && !thick.empty())) result.insert(at);
  }
  return result;
}

inline bool joins(const Coord& voxel, const std::vector<Coord>& near) {
  std::vector<Coord> within[3];  // by largest distance
  for (const Coord& other : near)
    for (int k = distance(voxel, other); k < 3; ++k) within[k].push_back(other);
  return groups_of(near, near, 3) > 1 || groups_of(within[1], within[2], 1) > 1;
}

/// Whether the rules let a sliver of a round go.
/// @param start  the voxels at the start of the round.
/// @param left   those that are left.
inline bool may_go(const Fills& start, const std::set<Coord>& slivers, const Fills& left,
                   const Coord& voxel) {
  const auto in_body = [&](const Coord& other) { return !slivers.count(other); };
  const std::vector<Coord> body = neighbours(start, voxel, in_body);
  if (body.empty()) return false;
  for (const Coord& other : neighbours(start, voxel, std::not_fn(in_body)))
    if (std::none_of(body.begin(), body.end(),
                     [&](const Coord& b) { return distance(other, b) <= 3; }))
      return false;
  return !joins(voxel, body) &&
         !joins(voxel, neighbours(left, voxel, [](const Coord&) { return true; }));
}

/// One round: lets the emptiest go that may, and starts again, until none may.
inline Fills after_a_round(const Fills& start) {
  const std::set<Coord> slivers = slivers_of(start);
  Fills left = start;
  while (true) {
    std::vector<std::tuple<long, uint64_t, Coord>> candidates;
    for (const Coord& coord : slivers)
      if (left.count(coord) && may_go(start, slivers, left, coord))
        candidates.push_back({static_cast<long>(start.at(coord) * 1e4), brick_key(coord), coord});
    if (candidates.empty()) return left;
    left.erase(std::get<2>(*std::min_element(candidates.begin(), candidates.end())));
  }
}

/// The voxels that are dropped in rounds, until a round drops none.
inline std::set<Coord> dropped_one_by_one(const Fills& all) {
  Fills left = all;
  for (size_t before = 0; before != left.size();) {
    before = left.size();
    left = after_a_round(left);
  }
  std::set<Coord> result;
  for (const auto& [coord, fill] : all)
    if (!left.count(coord)) result.insert(coord);
  return result;
}

struct SliverCounts {
  int64_t voxels = 0, dropped = 0, kept = 0, hinges_before = 0, hinges_after = 0;
};

/// Compares the grid of a surface with all voxels that the surface touches: missing voxels are
/// thin, each sliver that is left is kept by a rule (the first `checked` are tested), the number of
/// pieces is unchanged, and the number of hinges is not larger.
inline SliverCounts expect_sliver_rules(const Surface& surface, const VoxelizeOptions& options,
                                        int64_t checked) {
  const CutBody body = cut_body(surface, options);
  const Voxelized result = voxelize(surface, options);
  const VoxelGrid whole = make_grid(body.voxels(), body.lattice.h, body.lattice.origin);
  SliverCounts counts = {whole.voxel_count(), result.report.dropped_slivers, 0, hinge_count(whole),
                         hinge_count(result.grid)};
  EXPECT_EQ(result.grid.pieces, whole.pieces);
  EXPECT_LE(counts.hinges_after, counts.hinges_before);
  EXPECT_EQ(result.grid.voxel_count(), whole.voxel_count() - counts.dropped);

  const BrickIndex index(result.grid.voxel_coord);
  // filled share of each voxel of the whole grid; 1 where no surface cuts it
  Fills all;
  for (int64_t v = 0; v < whole.voxel_count(); ++v) {
    const int32_t* at = whole.voxel_coord.row(v);
    all[{at[0], at[1], at[2]}] = 1;
  }
  for (int64_t c = 0; c < body.cells.count(); ++c)
    if (body.kept[c]) all[body.cells.coord[c]] = body.share(c);
  // missing voxels are thin, and slivers that are left may not go
  Fills left = all;
  for (const auto& [coord, fill] : all)
    if (index.find(coord) < 0) {
      EXPECT_LT(fill, 0.1);
      left.erase(coord);
    }
  EXPECT_EQ(static_cast<int64_t>(left.size()), result.grid.voxel_count());
  for (const auto& [coord, fill] : left) counts.kept += fill < 0.02;
  const std::set<Coord> slivers = slivers_of(left);
  for (const Coord& coord : slivers) {
    if (checked-- <= 0) break;
    EXPECT_FALSE(may_go(left, slivers, left, coord))
        << coord[0] << ' ' << coord[1] << ' ' << coord[2];
  }
  EXPECT_EQ(counts.kept, result.report.thin_voxels);
  return counts;
}

}  // namespace elastogen::test
