// SPDX-License-Identifier: Apache-2.0
#include "network/precondition/fold_nodes.hpp"

#include <algorithm>

namespace elastogen {
namespace {

constexpr double kLowest = 0.05;  // of the eigenvalues that are damped, over the largest

void sort_unique(std::vector<int32_t>& numbers) {
  std::ranges::sort(numbers);
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

std::vector<int32_t> corners_of(const VoxelGrid& grid, const std::vector<int32_t>& voxels) {
  std::vector<int32_t> nodes;
  for (const int32_t v : voxels)
    nodes.insert(nodes.end(), grid.corners.row(v), grid.corners.row(v) + 8);
  sort_unique(nodes);
  return nodes;
}

std::vector<int32_t> voxels_at(const VoxelGrid& grid, const std::vector<int32_t>& nodes) {
  std::vector<int32_t> voxels;
  for (const int32_t n : nodes)
    std::copy_if(grid.voxels.row(n), grid.voxels.row(n) + 8, std::back_inserter(voxels),
                 [](int32_t v) { return v >= 0; });
  sort_unique(voxels);
  return voxels;
}

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
  // nodes of these voxels, and of those beside them
  const VoxelGrid& grid = scene_.grid;
  nodes = apart.empty() ? std::vector<int32_t>()
                        : corners_of(grid, voxels_at(grid, corners_of(grid, apart)));
  std::erase_if(nodes, [&](int32_t n) { return !is_plain(n); });
  voxels = voxels_at(grid, nodes);
  // what H reaches from there
  place.assign(size_t(grid.node_count()), -1);
  reached = nodes;
  for (size_t k = 0; k < nodes.size(); ++k) place[size_t(nodes[k])] = int32_t(k);
  for (const int32_t n : corners_of(grid, voxels))
    if (place[size_t(n)] < 0 && scene_.pinned(n) == kFreeNode) {
      place[size_t(n)] = int32_t(reached.size());
      reached.push_back(n);
    }
}

void FoldNodes::find_columns() {
  begin.assign(1, 0);
  columns.clear();
  std::vector<int32_t> places;
  for (const int32_t n : nodes) {
    places.clear();
    for (int c = 0; c < 8; ++c) {
      const int32_t voxel = scene_.grid.voxels(n, c);
      for (int b = 0; voxel >= 0 && b < 8; ++b) {
        const int32_t column = place[size_t(scene_.grid.corners(voxel, b))];
        if (column >= 0) places.push_back(column);
      }
    }
    sort_unique(places);
    columns.insert(columns.end(), places.begin(), places.end());
    begin.push_back(int32_t(columns.size()));
  }
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
