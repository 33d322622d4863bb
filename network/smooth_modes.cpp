// SPDX-License-Identifier: Apache-2.0
#include "network/smooth_modes.hpp"

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

using Place = std::array<int32_t, 3>;  // lattice coordinates

Place place_of(const VoxelGrid& grid, int64_t node) {
  return {grid.node_coord(node, 0), grid.node_coord(node, 1), grid.node_coord(node, 2)};
}

int64_t square_between(const Place& a, const Place& b) {
  int64_t sum = 0;
  for (size_t d = 0; d < 3; ++d) sum += int64_t(a[d] - b[d]) * (a[d] - b[d]);
  return sum;
}

struct PlaceBox {
  Place lower, upper;

  void add(const PlaceBox& o) {
    for (size_t d = 0; d < 3; ++d) {
      lower[d] = std::min(lower[d], o.lower[d]);
      upper[d] = std::max(upper[d], o.upper[d]);
    }
  }
  int64_t square_to(const Place& at) const {
    int64_t sum = 0;
    for (size_t d = 0; d < 3; ++d) {
      const int64_t away = std::max({lower[d] - at[d], at[d] - upper[d], 0});
      sum += away * away;
    }
    return sum;
  }
};

/// Of the listed nodes; without any, planes 0 and -1.
PlaceBox box_of(const VoxelGrid& grid, const std::vector<int32_t>& nodes) {
  const auto count = int64_t(nodes.size());
  if (count == 0) return {{}, {-1, -1, -1}};
  const Place first = place_of(grid, nodes[0]);
  std::vector<PlaceBox> boxes(size_t((count + kBlock - 1) / kBlock), {first, first});
  for_each(count, [&](int64_t k) {
    const Place at = place_of(grid, nodes[size_t(k)]);
    boxes[size_t(k / kBlock)].add({at, at});
  });
  for (const PlaceBox& box : boxes) boxes[0].add(box);
  return boxes[0];
}

/// Places, few and near each other in a box, and boxes in pairs in those of the next level.
class PlaceTree {
 public:
  explicit PlaceTree(std::vector<Place>&& places) : places_(std::move(places)) {
    std::vector<PlaceBox> boxes;
    for (size_t k = 0; k < places_.size(); ++k) add(k / kLeaf, {places_[k], places_[k]}, boxes);
    while (boxes.size() > 1) {
      std::vector<PlaceBox> pairs;
      for (size_t k = 0; k < boxes.size(); ++k) add(k / 2, boxes[k], pairs);
      levels_.push_back(std::move(boxes));
      boxes = std::move(pairs);
    }
    levels_.push_back(std::move(boxes));
  }

  bool empty() const { return places_.empty(); }
  const Place& first() const { return places_.front(); }

  /// The nearest to `at`, or `known` where none is nearer.
  Place nearest(const Place& at, const Place& known) const {
    Search search{at, known, square_between(at, known)};
    visit(levels_.size() - 1, 0, search);
    return search.found;
  }

 private:
  static constexpr size_t kLeaf = 8;
  struct Search {
    Place at, found;
    int64_t square;
  };

  static void add(size_t k, const PlaceBox& box, std::vector<PlaceBox>& to) {
    if (k == to.size())
      to.push_back(box);
    else
      to[k].add(box);
  }

  /// Box k of a level, if it can hold a nearer one.
  void visit(size_t level, size_t k, Search& search) const {
    if (levels_[level][k].square_to(search.at) >= search.square) return;
    if (level > 0) {
      const std::vector<PlaceBox>& below = levels_[level - 1];
      const size_t a = 2 * k, b = std::min(2 * k + 1, below.size() - 1);
      const bool turn = below[b].square_to(search.at) < below[a].square_to(search.at);
      visit(level - 1, turn ? b : a, search);
      if (a != b) visit(level - 1, turn ? a : b, search);
      return;
    }
    for (size_t p = kLeaf * k; p < std::min(kLeaf * (k + 1), places_.size()); ++p) {
      const int64_t square = square_between(search.at, places_[p]);
      if (square < search.square) search.square = square, search.found = places_[p];
    }
  }

  std::vector<Place> places_;
  std::vector<std::vector<PlaceBox>> levels_;
};

/// A pinned node with pinned nodes all around: one of those is nearer to any other node.
bool is_inner_pin(const Scene& scene, int64_t node) {
  for (int c = 0; c < 8; ++c) {
    const int32_t v = scene.grid.voxels(node, c);
    if (v < 0) return false;
    for (int e = 0; e < 8; ++e)
      if (!scene.pinned(scene.grid.corners(v, e))) return false;
  }
  return true;
}

/// The outer pins of each piece.
std::vector<PlaceTree> pin_trees(const Scene& scene, const std::vector<int32_t>& nodes) {
  const VoxelGrid& grid = scene.grid;
  const std::vector<int32_t> pins = filtered(int64_t(nodes.size()), [&](int64_t k) {
    const int32_t n = nodes[size_t(k)];
    return scene.pinned(n) && !is_inner_pin(scene, n);
  });
  std::vector<std::vector<Place>> places(static_cast<size_t>(grid.pieces));
  for (const int32_t k : pins) {
    const int32_t n = nodes[size_t(k)];
    places[size_t(grid.piece(n))].push_back(place_of(grid, n));
  }
  std::vector<PlaceTree> trees;
  for (std::vector<Place>& of_piece : places) trees.emplace_back(std::move(of_piece));
  return trees;
}

}  // namespace

PlaneCosines::PlaneCosines(const VoxelGrid& grid, const std::vector<int32_t>& nodes,
                           std::vector<Wave> waves, const Box& box)
    : waves_(std::move(waves)) {
  const PlaceBox planes = box_of(grid, nodes);
  for (int d = 0; d < 3; ++d) {
    first_[d] = planes.lower[size_t(d)];
    for (int32_t plane = first_[d]; plane <= planes.upper[size_t(d)]; ++plane)
      for (const Wave& wave : waves_) {
        const double share =
            wave[size_t(d)] > 0 ? double(plane - first_[d]) * grid.h / box.extent(d) : 0;
        table_[d].push_back(std::cos(std::numbers::pi * wave[size_t(d)] * share));
      }
  }
}

Zeroed<double> pin_distance(const Scene& scene, const std::vector<int32_t>& nodes) {
  const VoxelGrid& grid = scene.grid;
  const std::vector<PlaceTree> trees = pin_trees(scene, nodes);
  Zeroed<double> distance(nodes.size());
  for_blocks(int64_t(nodes.size()), [&](int64_t begin, int64_t end) {
    const PlaceTree* tree = nullptr;
    Place pin = {};
    for (int64_t k = begin; k < end; ++k) {
      const int32_t n = nodes[size_t(k)];
      const PlaceTree& of_piece = trees[size_t(grid.piece(n))];
      if (of_piece.empty()) {
        distance[size_t(k)] = 1e300;
        continue;
      }
      const Place at = place_of(grid, n);
      // the pin of the node before is a good first guess
      if (tree != &of_piece) tree = &of_piece, pin = tree->first();
      pin = scene.pinned(n) ? at : tree->nearest(at, pin);
      distance[size_t(k)] = grid.h * std::sqrt(double(square_between(at, pin)));
    }
  });
  return distance;
}

}  // namespace elastogen
