// SPDX-License-Identifier: Apache-2.0
// The nodes around particles, in blocks of 4^d cells, and which particles are in which block.
//
// Particles of a block see a tile of 6^d nodes. Sums of particles into nodes go tile by tile, and a
// node adds the sums of its tiles in the order of the blocks. Particles of a block are summed cell
// by cell, within a cell by number. So every run gives the same bits on any number of threads.

#pragma once

#include "core/array.hpp"
#include "core/pack.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace elastogen::mpm {

/// Some particles of one cell, which share their nodes.
struct CellPack {
  alignas(64) double x[3][kLanes];  ///< places [m]
  int32_t particle[kLanes];         ///< lanes beyond count repeat the first
  int32_t count;
  int32_t base[3];  ///< coordinates of their first node in h
  int32_t place;    ///< place of this node in the tile
};

template <int d>
class ParticleGrid {
 public:
  static constexpr int kTileWidth = 6;
  static constexpr int kTile = d == 3 ? 216 : 36;  ///< nodes of a tile
  static constexpr int kOwn = d == 3 ? 64 : 16;    ///< nodes, and cells, of a block
  static constexpr int kNeighbours = d == 3 ? 8 : 4;

  explicit ParticleGrid(double h) : h_(h) {}

  /// Finds the blocks of these points, and the nodes that they touch. Points that stayed in their
  /// cells since the last call cost little.
  /// @param x  [m], (count, 3)
  /// @throws Error (resources) where a point is not finite or farther than 2^20 h from the origin
  void update(In<double> x);

  double h() const { return h_; }
  int64_t blocks() const { return int64_t(block_.size()); }
  int64_t nodes() const { return int64_t(place_.size()); }
  /// Particles of block b: order()[first(b)] ... order()[first(b + 1) - 1].
  int64_t first(int64_t b) const { return first_[size_t(b)]; }
  const std::vector<int32_t>& order() const { return order_; }
  /// Packs of block b: packs()[first_pack(b)] ... packs()[first_pack(b + 1) - 1].
  int64_t first_pack(int64_t b) const { return first_pack_[size_t(b)]; }
  const std::vector<CellPack>& packs() const { return packs_; }

  /// Coordinates of a node in h, (3); the third is 0 in the plane.
  const std::array<int32_t, 3>& place(int64_t node) const { return place_[size_t(node)]; }
  /// First cell of block b.
  std::array<int32_t, 3> corner(int64_t b) const;
  /// Node of each place of the tile of block b, x + 6 (y + 6 z), or -1, (kTile).
  const int32_t* tile(int64_t b) const { return tile_node_.data() + b * kTile; }
  /// Places in the tiles, b kTile + place, that add up to a node.
  const int64_t* sources_begin(int64_t node) const {
    return source_.data() + first_source_[size_t(node)];
  }
  const int64_t* sources_end(int64_t node) const {
    return source_.data() + first_source_[size_t(node) + 1];
  }

 private:
  struct Owner {  // a block of nodes
    std::array<int32_t, 3> corner;
    std::array<int32_t, kNeighbours> reached_by;  // the blocks below whose tiles reach it, or -1
  };
  void check_places(In<double> x) const;
  void sort_moved(In<double> x);
  void find_blocks();
  int64_t pack_end(int64_t k, int64_t end) const;
  void make_packs(In<double> x);
  void mark_tiles();
  void number_nodes();
  Owner find_owner(uint64_t key) const;
  int64_t source_of(const Owner& owner, int own, int n) const;
  void count_nodes(const Owner& owner, int64_t& nodes, int64_t& sources) const;
  void write_nodes(const Owner& owner, int64_t node, int64_t source);

  double h_;
  std::vector<uint64_t> key_;    // of each particle: block and cell within it
  std::vector<int32_t> order_;   // particles by key, then number
  std::vector<uint64_t> block_;  // keys of the blocks with particles, ascending
  std::vector<int64_t> first_;   // (blocks + 1)
  std::vector<CellPack> packs_;
  std::vector<int64_t> first_pack_;  // (blocks + 1)
  std::vector<uint8_t> touched_;     // of the places of the tiles, (blocks, kTile)
  std::vector<int32_t> tile_node_;
  std::vector<std::array<int32_t, 3>> place_;
  std::vector<int64_t> first_source_, source_;
};

extern template class ParticleGrid<2>;
extern template class ParticleGrid<3>;

}  // namespace elastogen::mpm
