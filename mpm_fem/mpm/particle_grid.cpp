// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/mpm/particle_grid.hpp"

#include "core/error.hpp"
#include "core/parallel_sort.hpp"
#include "core/scan.hpp"
#include "mpm_fem/mpm/spline.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen::mpm {
namespace {

constexpr int kBits = 19;                        // of a block's place along an axis
constexpr int64_t kFarthest = int64_t(1) << 20;  // cells from the origin
constexpr int64_t kShift = int64_t(1) << (kBits - 1);
constexpr uint64_t kMask = (uint64_t(1) << kBits) - 1;

/// Blocks in the order of z, y, x.
uint64_t block_key(const int64_t b[3]) {
  return uint64_t(b[2] + kShift) << (2 * kBits) | uint64_t(b[1] + kShift) << kBits |
         uint64_t(b[0] + kShift);
}

std::array<int32_t, 3> block_place(uint64_t key) {
  std::array<int32_t, 3> b;
  for (size_t a = 0; a < 3; ++a) b[a] = int32_t(int64_t(key >> (kBits * int(a)) & kMask) - kShift);
  return b;
}

/// The key of the n-th block above (sign = 1) or below (-1); bit a of n is the step along axis a.
uint64_t shifted(uint64_t key, int n, int sign) {
  const std::array<int32_t, 3> at = block_place(key);
  const int64_t to[3] = {at[0] + sign * (n & 1), at[1] + sign * (n >> 1 & 1),
                         at[2] + sign * (n >> 2)};
  return block_key(to);
}

template <int d>
uint64_t cell_key(const double* x, double h) {
  int64_t block[3] = {};
  uint64_t cell = 0;
  for (int a = d; a-- > 0;) {
    const int64_t base = first_node(x[a] / h);
    block[a] = base >> 2;
    cell = cell << 2 | uint64_t(base & 3);
  }
  return block_key(block) << (2 * d) | cell;
}

/// Coordinates of the k-th of width^d places.
template <int d>
std::array<int, 3> unfold(int k, int width) {
  return {k % width, d == 3 ? k / width % width : k / width, d == 3 ? k / (width * width) : 0};
}

}  // namespace

template <int d>
std::array<int32_t, 3> ParticleGrid<d>::corner(int64_t b) const {
  std::array<int32_t, 3> c = block_place(block_[size_t(b)]);
  for (int32_t& a : c) a *= 4;
  return c;
}

/// @throws Error where a point has no place in the grid
template <int d>
void ParticleGrid<d>::check_places(In<double> x) const {
  const double outside = ordered_sum(x.rows, [&](int64_t begin, int64_t end) {
    int64_t count = 0;
    for (int64_t p = begin; p < end; ++p)
      for (int a = 0; a < d; ++a) count += !(std::abs(x(p, a)) < double(kFarthest) * h_);
    return double(count);
  });
  if (outside > 0)
    throw Error(concat("particles are not finite, or farther than 2^20 cells of ", h_,
                       " m from the origin"),
                ErrorKind::kResources);
}

/// Sorts the particles that left their cells in among the others, which stay in order.
template <int d>
void ParticleGrid<d>::sort_moved(In<double> x) {
  // with a new count of particles all have moved
  if (int64_t(key_.size()) != x.rows) {
    key_.assign(size_t(x.rows), ~uint64_t(0));
    order_.resize(size_t(x.rows));
    std::iota(order_.begin(), order_.end(), 0);
  }
  std::vector<uint8_t> moved(order_.size());
  for_each(x.rows, [&](int64_t p) {
    const uint64_t key = cell_key<d>(x.row(p), h_);
    moved[size_t(p)] = key != key_[size_t(p)];
    key_[size_t(p)] = key;
  });
  // particles that stayed, and those that left
  const auto groups =
      grouped(x.rows, 2, [&](int64_t k) { return int64_t(moved[size_t(order_[size_t(k)])]); });
  if (groups[1].empty()) return;
  const auto before = [&](int32_t a, int32_t b) {
    return key_[size_t(a)] != key_[size_t(b)] ? key_[size_t(a)] < key_[size_t(b)] : a < b;
  };
  std::vector<int32_t> stayed(groups[0].size()), left(groups[1].size());
  for_each(int64_t(stayed.size()),
           [&](int64_t k) { stayed[size_t(k)] = order_[size_t(groups[0][size_t(k)])]; });
  for (size_t k = 0; k < left.size(); ++k) left[k] = order_[size_t(groups[1][k])];
  // sort the latter, and merge
  parallel_sort(left.begin(), left.end(), before);
  std::merge(stayed.begin(), stayed.end(), left.begin(), left.end(), order_.begin(), before);
}

template <int d>
void ParticleGrid<d>::find_blocks() {
  const auto block_of = [&](int64_t k) { return key_[size_t(order_[size_t(k)])] >> (2 * d); };
  const std::vector<int32_t> begins = filtered(
      int64_t(order_.size()), [&](int64_t k) { return k == 0 || block_of(k) != block_of(k - 1); });
  block_.resize(begins.size());
  first_.assign(begins.begin(), begins.end());
  first_.push_back(int64_t(order_.size()));
  for_each(blocks(), [&](int64_t b) { block_[size_t(b)] = block_of(begins[size_t(b)]); });
}

/// The end of the pack that begins at place k of the order.
template <int d>
int64_t ParticleGrid<d>::pack_end(int64_t k, int64_t end) const {
  const auto key = [&](int64_t at) { return key_[size_t(order_[size_t(at)])]; };
  int64_t next = k + 1;
  while (next < end && next < k + kLanes && key(next) == key(k)) ++next;
  return next;
}

template <int d>
void ParticleGrid<d>::make_packs(In<double> x) {
  // count of packs of each block
  std::vector<int64_t> packs(block_.size());
  for_each(
      blocks(),
      [&](int64_t b) {
        for (int64_t k = first(b); k < first(b + 1); k = pack_end(k, first(b + 1)))
          ++packs[size_t(b)];
      },
      16);
  first_pack_.resize(size_t(blocks() + 1));
  exclusive_sum(packs.data(), blocks(), first_pack_.data());
  packs_.resize(size_t(first_pack_.back()));
  // their cell, particles and places
  run_tasks(blocks(), [&](int64_t b) {
    const std::array<int32_t, 3> from = corner(b);
    CellPack* pack = packs_.data() + first_pack(b);
    for (int64_t k = first(b); k < first(b + 1); k += pack++->count) {
      const uint64_t key = key_[size_t(order_[size_t(k)])];
      const std::array<int, 3> cell = unfold<d>(int(key & (kOwn - 1)), 4);
      pack->count = int32_t(pack_end(k, first(b + 1)) - k);
      pack->place = cell[0] + kTileWidth * (cell[1] + kTileWidth * cell[2]);
      for (size_t a = 0; a < 3; ++a) pack->base[a] = from[a] + cell[a];
      for (int lane = 0; lane < kLanes; ++lane) {
        const int32_t p = order_[size_t(lane < pack->count ? k + lane : k)];
        pack->particle[lane] = p;
        for (int a = 0; a < 3; ++a) pack->x[a][lane] = x(p, a);
      }
    }
  });
}

/// Marks the places of the tiles that particles touch.
template <int d>
void ParticleGrid<d>::mark_tiles() {
  touched_.assign(size_t(blocks() * kTile), 0);
  run_tasks(blocks(), [&](int64_t b) {
    uint8_t* tile = touched_.data() + b * kTile;
    for (int64_t k = first_pack(b); k < first_pack(b + 1); ++k)
      for (int n = 0; n < (d == 3 ? 27 : 9); ++n) {
        const std::array<int, 3> o = unfold<d>(n, 3);
        tile[packs_[size_t(k)].place + o[0] + kTileWidth * (o[1] + kTileWidth * o[2])] = 1;
      }
  });
}

/// Numbers the nodes in the order of the blocks that own them. Nodes on a block's upper faces
/// belong to other blocks, which may have no particles.
template <int d>
void ParticleGrid<d>::number_nodes() {
  // blocks that own nodes
  std::vector<uint64_t> key;
  key.reserve(size_t(blocks() * kNeighbours));
  for (const uint64_t own : block_)
    for (int n = 0; n < kNeighbours; ++n) key.push_back(shifted(own, n, 1));
  parallel_sort(key.begin(), key.end());
  key.erase(std::unique(key.begin(), key.end()), key.end());

  // count of their nodes and of the sources of these
  std::vector<Owner> owners(key.size());
  const auto count = int64_t(key.size());
  std::vector<int64_t> nodes(key.size()), sources(key.size());
  for_each(
      count,
      [&](int64_t o) {
        owners[size_t(o)] = find_owner(key[size_t(o)]);
        count_nodes(owners[size_t(o)], nodes[size_t(o)], sources[size_t(o)]);
      },
      16);
  // numbers by prefix sums, then nodes and sources block by block
  std::vector<int64_t> first_node(key.size() + 1), first_source(key.size() + 1);
  exclusive_sum(nodes.data(), count, first_node.data());
  exclusive_sum(sources.data(), count, first_source.data());
  place_.resize(size_t(first_node.back()));
  first_source_.resize(place_.size() + 1);
  first_source_.back() = first_source.back();
  source_.resize(size_t(first_source.back()));
  tile_node_.assign(size_t(blocks() * kTile), -1);
  for_each(
      count,
      [&](int64_t o) {
        write_nodes(owners[size_t(o)], first_node[size_t(o)], first_source[size_t(o)]);
      },
      16);
}

template <int d>
typename ParticleGrid<d>::Owner ParticleGrid<d>::find_owner(uint64_t key) const {
  Owner owner;
  owner.corner = block_place(key);
  for (int32_t& a : owner.corner) a *= 4;
  for (int n = 0; n < kNeighbours; ++n) {
    const uint64_t down = shifted(key, n, -1);
    const auto found = std::lower_bound(block_.begin(), block_.end(), down);
    const bool exists = found != block_.end() && *found == down;
    owner.reached_by[size_t(n)] = exists ? int32_t(found - block_.begin()) : -1;
  }
  return owner;
}

/// Entry b kTile + place of the tile through which the n-th block below touches a node, or -1.
template <int d>
int64_t ParticleGrid<d>::source_of(const Owner& owner, int own, int n) const {
  const int32_t b = owner.reached_by[size_t(n)];
  const std::array<int, 3> o = unfold<d>(own, 4);
  const int t[3] = {o[0] + 4 * (n & 1), o[1] + 4 * (n >> 1 & 1), o[2] + 4 * (n >> 2)};
  if (b < 0 || std::max({t[0], t[1], t[2]}) >= kTileWidth) return -1;
  const int64_t entry = int64_t(b) * kTile + t[0] + kTileWidth * (t[1] + kTileWidth * t[2]);
  return touched_[size_t(entry)] ? entry : -1;
}

template <int d>
void ParticleGrid<d>::count_nodes(const Owner& owner, int64_t& nodes, int64_t& sources) const {
  for (int own = 0; own < kOwn; ++own) {
    int64_t found = 0;
    for (int n = 0; n < kNeighbours; ++n) found += source_of(owner, own, n) >= 0;
    nodes += found > 0;
    sources += found;
  }
}

template <int d>
void ParticleGrid<d>::write_nodes(const Owner& owner, int64_t node, int64_t source) {
  for (int own = 0; own < kOwn; ++own) {
    const int64_t begin = source;
    for (int n = kNeighbours; n-- > 0;) {  // the lowest block first
      const int64_t entry = source_of(owner, own, n);
      if (entry < 0) continue;
      source_[size_t(source++)] = entry;
      tile_node_[size_t(entry)] = int32_t(node);
    }
    if (source == begin) continue;
    const std::array<int, 3> in = unfold<d>(own, 4);
    for (size_t a = 0; a < 3; ++a) place_[size_t(node)][a] = owner.corner[a] + in[a];
    first_source_[size_t(node++)] = begin;
  }
}

template <int d>
void ParticleGrid<d>::update(In<double> x) {
  check_places(x);
  sort_moved(x);
  find_blocks();
  make_packs(x);
  mark_tiles();
  number_nodes();
}

template class ParticleGrid<2>;
template class ParticleGrid<3>;

}  // namespace elastogen::mpm
