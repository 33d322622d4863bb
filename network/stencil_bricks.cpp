// SPDX-License-Identifier: Apache-2.0
#include "network/stencil_bricks.hpp"

#include "network/multigrid_element.hpp"

#include <algorithm>
#include <string_view>
#include <unordered_map>

namespace elastogen {
namespace {

using stencil::kComponent;
using stencil::kRow;
using stencil::kSlots;
using Coord = std::array<int32_t, 3>;

/// Index of each brick by its coordinate.
class BrickMap {
 public:
  explicit BrickMap(const std::vector<Coord>& coord) : none_(int32_t(coord.size())) {
    for (const Coord& at : coord) index_.emplace(key(at), int32_t(index_.size()));
  }
  /// The number of bricks where there is none.
  int32_t find(const Coord& at) const {
    const auto found = index_.find(key(at));
    return found == index_.end() ? none_ : found->second;
  }

 private:
  static uint64_t key(const Coord& at) {
    const auto part = [](int32_t a) { return uint64_t(uint32_t(a + (1 << 20))) & 0x1fffff; };
    return part(at[0]) << 42 | part(at[1]) << 21 | part(at[2]);
  }
  std::unordered_map<uint64_t, int32_t> index_;
  int32_t none_;
};

int32_t place_of(int x, int y, int z) {
  return (x & 7) + 8 * ((y & 7) + 8 * (z & 7));
}

/// Bricks at `base` plus offsets first, ..., first + count - 1 per axis, x fastest.
void find_block(const BrickMap& map, const Coord& base, int first, int count, int32_t* found) {
  for (int z = 0; z < count; ++z)
    for (int y = 0; y < count; ++y)
      for (int x = 0; x < count; ++x)
        *found++ = map.find({base[0] + first + x, base[1] + first + y, base[2] + first + z});
}

template <class T>
void number_slots(const Array<int32_t>& node_coord, StencilBricks<T>& g) {
  const auto brick_of = [&](int64_t n) {
    const int32_t* at = node_coord.row(n);
    return Coord{at[0] >> 3, at[1] >> 3, at[2] >> 3};
  };
  g.begin = filtered(node_coord.rows(),
                     [&](int64_t n) { return n == 0 || brick_of(n) != brick_of(n - 1); });
  for (const int32_t n : g.begin) g.coord.push_back(brick_of(n));
  g.begin.push_back(int32_t(node_coord.rows()));
  g.slot.resize(size_t(node_coord.rows()));
  run_tasks(g.brick_count(), [&](int64_t b) {
    for (int32_t n = g.begin[size_t(b)]; n < g.begin[size_t(b + 1)]; ++n) {
      const int32_t* at = node_coord.row(n);
      g.slot[size_t(n)] = kSlots * int32_t(b) + place_of(at[0], at[1], at[2]);
    }
  });
}

/// Row and lane, kLanes row + lane, of the voxel whose corner 0 is at a slot; -1 if none.
template <class T>
Zeroed<int32_t> voxels_at_slots(const MultigridLevel<T>& level, const BrickMap& map,
                                int64_t bricks) {
  const BrickRows& rows = level.rows;
  Zeroed<int32_t> voxel(size_t(kSlots * bricks));
  for_each(int64_t(voxel.size()), [&](int64_t k) { voxel[size_t(k)] = -1; });
  run_tasks(rows.brick_count(), [&](int64_t b) {
    // a node's place in the tile tells where the brick lies
    const size_t entry = size_t(rows.tile_begin[size_t(b)]);
    const int32_t* at = level.node_coord.row(rows.tile_node[entry]);
    const int place = rows.tile_place[entry];
    const int32_t home = map.find(
        {(at[0] - place % 9) >> 3, (at[1] - place / 9 % 9) >> 3, (at[2] - place / 81) >> 3});
    for (int32_t r = rows.row_begin[size_t(b)]; r < rows.row_begin[size_t(b + 1)]; ++r) {
      const VoxelRow& row = rows.rows[size_t(r)];
      const int line = row.offset / bricks::kTileWidth;
      for (int lane = 0; lane < kLanes; ++lane)
        if (row.mask >> lane & 1)
          voxel[size_t(kSlots * home + place_of(lane, line % 9, line / 9))] = kLanes * r + lane;
    }
  });
  return voxel;
}

/// The different rows of one brick.
template <class T>
struct BrickStencils {
  std::vector<T> values;          // (rows, 3, kComponent)
  std::vector<uint8_t> is_plain;  // no border voxel around: other bricks may well have it too
};

/// Makes the rows of one brick after the other.
template <class T>
class RowMaker {
 public:
  RowMaker(const MultigridLevel<T>& level, const StencilBricks<T>& g, const BrickMap& map)
      : level_(level),
        g_(g),
        voxel_at_(voxels_at_slots(level, map, g.brick_count())),
        pinned_(size_t(kSlots * g.brick_count())),
        has_pins_(size_t(g.brick_count() + 1)) {
    run_tasks(g.brick_count(), [&](int64_t b) {
      for (int32_t n = g.begin[size_t(b)]; n < g.begin[size_t(b + 1)]; ++n)
        if (level.pinned[size_t(n)]) pinned_[size_t(g.slot[size_t(n)])] = has_pins_[size_t(b)] = 1;
    });
  }

  /// The rows of a brick's free nodes; `row` of its slots becomes 1 + their index there.
  BrickStencils<T> make(int64_t brick, int32_t* row) const {
    BrickStencils<T> rows;
    const int32_t* around_brick = g_.links[size_t(brick)].neighbour;
    const bool near_pins = std::any_of(around_brick, around_brick + 27,
                                       [&](int32_t b) { return has_pins_[size_t(b)] != 0; });
    Node last;
    for (int32_t n = g_.begin[size_t(brick)]; n < g_.begin[size_t(brick + 1)]; ++n) {
      if (level_.pinned[size_t(n)]) continue;
      Node node = around(n);
      if (near_pins) node.pins = pins_around(n);
      int32_t& index = row[g_.slot[size_t(n)]];
      if (last.number >= 0 && alike(last, node)) {
        index = row[g_.slot[size_t(last.number)]];
      } else {
        T weights[kRow];
        assemble(node, weights);
        index = find_or_add(weights, is_plain(node), rows);
      }
      last = node;
    }
    return rows;
  }

 private:
  struct Node {
    int32_t number = -1;
    int32_t voxel[8];   ///< of which the node is corner c
    uint32_t pins = 0;  ///< which of the 27 nodes around it, in the order of the weights
  };

  Node around(int32_t n) const {
    Node node{n, {}};
    for (int c = 0; c < 8; ++c) {
      const int64_t slot = slot_beside(n, -(c & 1), -(c >> 1 & 1), -(c >> 2));
      node.voxel[c] = slot < 0 ? -1 : voxel_at_[size_t(slot)];
    }
    return node;
  }

  uint32_t pins_around(int32_t n) const {
    uint32_t pins = 0;
    for (int k = 0; k < 27; ++k) {
      const int64_t slot = slot_beside(n, k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
      if (slot >= 0 && pinned_[size_t(slot)]) pins |= 1u << k;
    }
    return pins;
  }

  /// The slot at an offset from a node; -1 where there is no brick.
  int64_t slot_beside(int32_t n, int dx, int dy, int dz) const {
    const int32_t slot = g_.slot[size_t(n)];
    const int x = slot % 8 + dx, y = slot / 8 % 8 + dy, z = slot / 64 % 8 + dz;
    const int side = (x >> 3) + 1 + 3 * ((y >> 3) + 1) + 9 * ((z >> 3) + 1);
    const int32_t brick = g_.links[size_t(slot / kSlots)].neighbour[side];
    return brick == g_.brick_count() ? -1 : kSlots * int64_t(brick) + place_of(x, y, z);
  }

  T modulus(int32_t voxel, int j) const {
    return level_
        .moduli[(size_t(voxel / kLanes) * 6 + size_t(j)) * kLanes + size_t(voxel % kLanes)];
  }
  int32_t border(int32_t voxel) const { return level_.rows.rows[size_t(voxel / kLanes)].border; }

  /// Whether two nodes surely have one row.
  bool alike(const Node& a, const Node& b) const {
    if (a.pins != b.pins) return false;
    for (int i = 0; i < 3; ++i) {
      const size_t k = 3 * size_t(a.number) + size_t(i), m = 3 * size_t(b.number) + size_t(i);
      if (level_.added[k] != level_.added[m]) return false;
      if (level_.inverse_diagonal[k] != level_.inverse_diagonal[m]) return false;
    }
    for (int c = 0; c < 8; ++c) {
      const int32_t v = a.voxel[c], w = b.voxel[c];
      if (v == w) continue;
      if (v < 0 || w < 0 || border(v) >= 0 || border(w) >= 0) return false;
      for (int j = 0; j < 6; ++j)
        if (modulus(v, j) != modulus(w, j)) return false;
    }
    return true;
  }

  /// Adds what corner c of a voxel gets from its corners to the weights of a node.
  void add_voxel(int32_t voxel, int c, double weights[3][27]) const {
    double k[6], M[7] = {};
    for (int j = 0; j < 6; ++j) k[j] = double(modulus(voxel, j));
    if (const int32_t b = border(voxel); b >= 0)
      for (int m = 0; m < 7; ++m)
        M[m] = level_.rows.border[(size_t(b) * 7 + size_t(m)) * kLanes + size_t(voxel % kLanes)];
    for (int i = 0; i < 3; ++i) {
      double unit[8] = {}, f[8];
      unit[c] = 1;
      scalar_element<true>(k, M, i, unit, f);  // a column, which is the row
      for (int q = 0; q < 8; ++q) {
        const int dx = (q & 1) - (c & 1), dy = (q >> 1 & 1) - (c >> 1 & 1),
                  dz = (q >> 2) - (c >> 2);
        weights[i][13 + dx + 3 * dy + 9 * dz] += f[q];
      }
    }
  }

  void assemble(const Node& node, T row[kRow]) const {
    double weights[3][27] = {};
    for (int c = 0; c < 8; ++c)
      if (node.voxel[c] >= 0) add_voxel(node.voxel[c], c, weights);
    for (int i = 0; i < 3; ++i) {
      const size_t k = 3 * size_t(node.number) + size_t(i);
      for (int j = 0; j < 27; ++j)
        if (node.pins >> j & 1) weights[i][j] = 0;
      weights[i][13] += double(level_.added[k]);
      std::copy(weights[i], weights[i] + 27, row + kComponent * i);
      row[kComponent * i + 27] = level_.inverse_diagonal[k];
    }
  }

  bool is_plain(const Node& node) const {
    return std::all_of(node.voxel, node.voxel + 8,
                       [&](int32_t voxel) { return voxel < 0 || border(voxel) < 0; });
  }

  /// 1 + the index of a row, which is looked for among the newest only: one that stands twice costs
  /// memory and nothing else.
  static int32_t find_or_add(const T row[kRow], bool is_plain, BrickStencils<T>& rows) {
    constexpr int32_t kRecent = 32;
    const int32_t count = int32_t(rows.is_plain.size());
    for (int32_t k = count; k > std::max(0, count - kRecent); --k)
      if (std::equal(row, row + kRow, rows.values.data() + kRow * (k - 1))) return k;
    rows.values.insert(rows.values.end(), row, row + kRow);
    rows.is_plain.push_back(is_plain);
    return count + 1;
  }

  const MultigridLevel<T>& level_;
  const StencilBricks<T>& g_;
  Zeroed<int32_t> voxel_at_;
  Zeroed<uint8_t> pinned_;    // of each slot
  Zeroed<uint8_t> has_pins_;  // of each brick, and of those that are missing
};

/// Row 0 and the rows of all bricks, plain ones once; `row` becomes their index.
template <class T>
void gather_rows(const std::vector<BrickStencils<T>>& bricks, StencilBricks<T>& g) {
  std::unordered_map<std::string_view, int32_t> plain;
  std::vector<const T*> rows;
  std::vector<std::vector<int32_t>> number(bricks.size());
  for (size_t b = 0; b < bricks.size(); ++b)
    for (size_t k = 0; k < bricks[b].is_plain.size(); ++k) {
      const T* row = bricks[b].values.data() + kRow * k;
      int32_t index = int32_t(rows.size()) + 1;
      if (bricks[b].is_plain[k]) {
        const std::string_view bytes(reinterpret_cast<const char*>(row), kRow * sizeof(T));
        index = plain.try_emplace(bytes, index).first->second;
      }
      if (index > int32_t(rows.size())) rows.push_back(row);
      number[b].push_back(index);
    }
  g.rows.resize(kRow * (rows.size() + 1));
  for_each(int64_t(rows.size()), [&](int64_t k) {
    std::copy(rows[size_t(k)], rows[size_t(k)] + kRow, g.rows.begin() + kRow * (k + 1));
  });
  for_each(int64_t(g.row.size()), [&](int64_t slot) {
    int32_t& row = g.row[size_t(slot)];
    if (row > 0) row = number[size_t(slot) / kSlots][size_t(row) - 1];
  });
}

}  // namespace

template <class T>
StencilBricks<T> make_stencil_bricks(const MultigridLevel<T>& level) {
  StencilBricks<T> g;
  number_slots(level.node_coord, g);
  const int64_t bricks = g.brick_count();
  const BrickMap map(g.coord);
  g.links.resize(size_t(bricks));
  g.row.resize(size_t(kSlots * bricks));
  run_tasks(bricks, [&](int64_t b) {
    const Coord& at = g.coord[size_t(b)];
    BrickLinks& links = g.links[size_t(b)];
    find_block(map, at, -1, 3, links.neighbour);
    links.odd = (at[0] & 1) | (at[1] & 1) << 1 | (at[2] & 1) << 2;
  });
  const RowMaker<T> maker(level, g, map);
  std::vector<BrickStencils<T>> rows(static_cast<size_t>(bricks));
  run_tasks(bricks, [&](int64_t b) { rows[size_t(b)] = maker.make(b, g.row.data()); });

  gather_rows(rows, g);
  return g;
}

template <class T>
void link_levels(StencilBricks<T>& finer, StencilBricks<T>& coarser) {
  const BrickMap fine(finer.coord), coarse(coarser.coord);
  run_tasks(finer.brick_count(), [&](int64_t b) {
    const Coord& at = finer.coord[size_t(b)];
    const Coord base = {(at[0] - 1) >> 1, (at[1] - 1) >> 1, (at[2] - 1) >> 1};
    find_block(coarse, base, 0, 2, finer.links[size_t(b)].coarse);
  });
  run_tasks(coarser.brick_count(), [&](int64_t b) {
    const Coord& at = coarser.coord[size_t(b)];
    find_block(fine, {2 * at[0], 2 * at[1], 2 * at[2]}, -1, 3, coarser.links[size_t(b)].fine);
  });
}

template StencilBricks<float> make_stencil_bricks(const MultigridLevel<float>&);
template StencilBricks<double> make_stencil_bricks(const MultigridLevel<double>&);
template void link_levels(StencilBricks<float>&, StencilBricks<float>&);
template void link_levels(StencilBricks<double>&, StencilBricks<double>&);

}  // namespace elastogen
