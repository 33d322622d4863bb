// SPDX-License-Identifier: Apache-2.0
#include "scene/loose_pieces.hpp"

#include "core/vec3.hpp"
#include "scene/piece_names.hpp"
#include "voxelize/labels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace elastogen {
namespace {

/// 1 for each piece in which a node is pinned, held or moved.
std::vector<uint8_t> held_pieces(const Setup& setup, const RunDescription& run) {
  const VoxelGrid& grid = setup.scene.grid;
  std::vector<uint8_t> held(size_t(grid.pieces), 0);
  const auto add = [&](const Array<uint8_t>& nodes) {
    for (int64_t n = 0; n < nodes.rows(); ++n) held[size_t(grid.piece(n))] |= nodes(n);
  };
  add(setup.scene.pinned);
  for (const Hold& hold : run.holds) add(selected_nodes(setup, hold.selection));
  for (const Move& move : run.moves) add(selected_nodes(setup, move.selection));
  return held;
}

/// Whether a point that falls meets a collider. The point is moved along the pull by its distance
/// to the nearest collider, repeatedly. A moving collider counts as met, as it may come by.
bool is_above_something(const Scene& scene, Vec3 x, double reach) {
  const Vec3 down = scaled(scene.gravity, 1 / norm(scene.gravity));
  const Vec3 start = x;
  for (int k = 0; k < 1000 && norm(minus(x, start)) < reach; ++k) {
    double nearest = reach;
    for (const Collider& c : scene.colliders)
      nearest = c.path.keys.empty() ? std::min(nearest, proximity(c, {}, x).distance) : 0;
    if (nearest < scene.grid.h / 4) return true;
    x = plus(x, scaled(down, nearest));
  }
  return false;
}

/// The triangle of the surface nearest to a point.
int64_t nearest_triangle(const Surface& surface, const Vec3& x) {
  double least = 1e300;
  int64_t nearest = 0;
  for (int64_t t = 0; t < surface.triangles.rows(); ++t) {
    Vec3 corner[3];
    for (int k = 0; k < 3; ++k)
      std::copy_n(surface.vertices.row(surface.triangles(t, k)), 3, corner[k].begin());
    const double d = triangle_distance2(corner, x);
    if (d < least) least = d, nearest = t;
  }
  return nearest;
}

/// The name that is nearest to most of the points.
std::string name_near(const Asset& asset, const Surface& surface, const std::vector<Vec3>& points) {
  std::map<std::string, int> votes;
  const size_t stride = points.size() / 16 + 1;
  for (size_t k = 0; k < points.size(); k += stride)
    ++votes[name_at(asset, surface, nearest_triangle(surface, points[k]))];
  return std::ranges::max_element(votes, {}, [](const auto& v) { return v.second; })->first;
}

/// At most 64 nodes of each piece.
std::vector<std::vector<Vec3>> samples_of(const VoxelGrid& grid) {
  std::vector<int64_t> count(size_t(grid.pieces), 0), seen(size_t(grid.pieces), 0);
  for (int64_t n = 0; n < grid.node_count(); ++n) ++count[size_t(grid.piece(n))];
  std::vector<std::vector<Vec3>> samples(size_t(grid.pieces));
  for (int64_t n = 0; n < grid.node_count(); ++n) {
    const auto p = size_t(grid.piece(n));
    if (seen[p]++ % (count[p] / 64 + 1) == 0)
      samples[p].push_back({grid.rest(n, 0), grid.rest(n, 1), grid.rest(n, 2)});
  }
  return samples;
}

}  // namespace

void judge_pieces(const Asset& asset, const RunDescription& run, Setup& setup) {
  constexpr size_t kShown = 3;
  const Scene& scene = setup.scene;
  if (scene.grid.pieces < 2) return;
  // nothing is loose if every piece is held
  const std::vector<uint8_t> held = held_pieces(setup, run);
  if (std::ranges::all_of(held, [](uint8_t h) { return h != 0; }))
    std::erase_if(setup.asset.findings, [](const Finding& f) { return f.what == "loose-pieces"; });
  // without gravity, or with nothing that holds or stops a piece, none falls away from others
  const bool any = std::ranges::any_of(held, [](uint8_t h) { return h != 0; });
  if (scene.gravity == Vec3{} || (!any && scene.colliders.empty())) return;

  // pieces that fall past all colliders, and the names of some
  const std::vector<std::vector<Vec3>> samples = samples_of(scene.grid);
  const double reach = 1000 * setup.longest_edge;
  int64_t count = 0;
  std::set<std::string> names;
  for (size_t p = 0; p < held.size(); ++p) {
    const auto lands = [&](const Vec3& x) { return is_above_something(scene, x, reach); };
    if (held[p] || std::ranges::any_of(samples[p], lands)) continue;
    ++count;
    if (names.size() <= kShown) names.insert(name_near(asset, setup.body.surface, samples[p]));
  }
  // a warning that lists them
  if (count == 0) return;
  names.erase("");
  std::string list;
  for (const std::string& name : names)
    list += fmt::format("{}'{}'", list.empty() ? " (" : ", ", name);
  if (!list.empty()) list += ')';
  setup.warnings.push_back(
      count == 1 ? fmt::format("1 of {} pieces{} is held by nothing and above nothing: it falls "
                               "freely; pin it too, or give --floor",
                               held.size(), list)
                 : fmt::format("{} of {} pieces{} are held by nothing and above nothing: they fall "
                               "freely; pin them too, or give --floor",
                               count, held.size(), list));
}

}  // namespace elastogen
