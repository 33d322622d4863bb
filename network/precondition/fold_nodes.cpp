// SPDX-License-Identifier: Apache-2.0
#include "network/precondition/fold_nodes.hpp"

#include "core/parallel.hpp"

#include <algorithm>
#include <span>

namespace elastogen {
namespace {

constexpr double kLowest = 0.05;  // of the eigenvalues that are damped, over the largest

using Marks = std::vector<uint8_t>;

void mark_corners(const VoxelGrid& grid, const std::vector<int32_t>& voxels, Marks& nodes) {
  for (const int32_t v : voxels)
    for (int c = 0; c < 8; ++c) nodes[size_t(grid.corners(v, c))] = 1;
}

void mark_voxels(const VoxelGrid& grid, const std::vector<int32_t>& nodes, Marks& voxels) {
  for (const int32_t n : nodes)
    for (int c = 0; c < 8; ++c)
      if (const int32_t v = grid.voxels(n, c); v >= 0) voxels[size_t(v)] = 1;
}

std::vector<int32_t> marked(const Marks& marks) {
  return filtered(int64_t(marks.size()), [&](int64_t k) { return marks[size_t(k)] != 0; });
}

/// Places of the nodes that share a voxel with a node, ascending.
struct Places {
  Places(const VoxelGrid& grid, const std::vector<int32_t>& place, int64_t node) {
    for (int c = 0; c < 8; ++c) {
      const int32_t voxel = grid.voxels(node, c);
      for (int b = 0; voxel >= 0 && b < 8; ++b)
        if (const int32_t at = place[size_t(grid.corners(voxel, b))]; at >= 0) of[count++] = at;
    }
    std::sort(of, of + count);
    count = int(std::unique(of, of + count) - of);
  }
  int32_t of[64];
  int count = 0;
};

}  // namespace

FoldNodes::FoldNodes(const Scene& scene) : scene_(scene) {
  if (!scene.dependent.empty()) is_parent_.resize(size_t(scene.grid.node_count()));
  for (const int32_t n : scene.dependent.folded().nodes) is_parent_[size_t(n)] = 1;
}

bool FoldNodes::is_plain(int64_t node) const {
  if (scene_.pinned(node) != kFreeNode || (!is_parent_.empty() && is_parent_[size_t(node)]))
    return false;
  for (int d = 0; d < 3 && !scene_.fixed.empty(); ++d)
    if (scene_.fixed(node, d) >= 0) return false;
  return true;
}

void FoldNodes::find_nodes(const std::vector<int32_t>& apart) {
  // voxels beside these, and their nodes
  const VoxelGrid& grid = scene_.grid;
  Marks near_nodes(size_t(grid.node_count())), near(size_t(grid.voxel_count()));
  mark_corners(grid, apart, near_nodes);
  mark_voxels(grid, marked(near_nodes), near);
  mark_corners(grid, marked(near), near_nodes);
  nodes =
      filtered(grid.node_count(), [&](int64_t n) { return near_nodes[size_t(n)] && is_plain(n); });
  mark_voxels(grid, nodes, near);
  // without those whose nodes were all left out
  voxels = filtered(grid.voxel_count(), [&](int64_t v) {
    return near[size_t(v)] &&
           std::ranges::any_of(std::span(grid.corners.row(v), 8),
                               [&](int32_t n) { return near_nodes[size_t(n)] && is_plain(n); });
  });
  // what H reaches from there
  Marks beside(near_nodes.size());
  mark_corners(grid, voxels, beside);
  place.assign(near_nodes.size(), -1);
  reached = nodes;
  for (size_t k = 0; k < nodes.size(); ++k) place[size_t(nodes[k])] = int32_t(k);
  for (const int32_t n : marked(beside))
    if (place[size_t(n)] < 0 && scene_.pinned(n) == kFreeNode) {
      place[size_t(n)] = int32_t(reached.size());
      reached.push_back(n);
    }
}

void FoldNodes::find_columns() {
  begin.assign(nodes.size() + 1, 0);
  for_each(count(), [&](int64_t k) {
    begin[size_t(k) + 1] = Places(scene_.grid, place, nodes[size_t(k)]).count;
  });
  for (size_t k = 1; k < begin.size(); ++k) begin[k] += begin[k - 1];
  columns.resize(size_t(begin.back()));
  for_each(count(), [&](int64_t k) {
    const Places places(scene_.grid, place, nodes[size_t(k)]);
    std::copy_n(places.of, places.count, columns.begin() + begin[size_t(k)]);
  });
}

void FoldNodes::find_transposed() {
  first.assign(reached.size() + 1, 0);
  for (const int32_t column : columns) ++first[size_t(column) + 1];
  for (size_t k = 1; k < first.size(); ++k) first[k] += first[k - 1];
  std::vector<int32_t> next = first;
  transposed.resize(columns.size());
  for (int32_t row = 0; row < int32_t(count()); ++row)
    for (int32_t e = begin[size_t(row)]; e < begin[size_t(row) + 1]; ++e)
      transposed[size_t(next[size_t(columns[size_t(e)])]++)] = {row, e};
}

bool FoldNodes::cover(const std::vector<int32_t>& apart) const {
  return !empty() && std::ranges::includes(voxels, apart);
}

void FoldNodes::find(const std::vector<int32_t>& apart) {
  find_nodes(apart);
  if (empty()) return;
  find_columns();
  find_transposed();
}

FoldSmoother fold_smoother() {
  const double theta = (1 + kLowest) / 2, delta = (1 - kLowest) / 2;
  FoldSmoother smoother{};
  double rho = delta / theta;
  smoother.add[0] = 1 / theta;
  for (size_t step = 1; step < smoother.add.size(); ++step) {
    const double next = 1 / (2 * theta / delta - rho);
    smoother.keep[step] = next * rho;
    smoother.add[step] = 2 * next / delta;
    rho = next;
  }
  return smoother;
}

}  // namespace elastogen
