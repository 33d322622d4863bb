// SPDX-License-Identifier: Apache-2.0
// The bricks of a level and their points on the device: what a slot holds, and the slots around it
// (core/bricks/links.hpp).

#pragma once

#include "core/bricks/links.hpp"
#include "core/cuda/array.cuh"

namespace elastogen::cuda {

using ::elastogen::bricks::kSlots;

/// The tables of DeviceBricks, as kernels read them.
struct BrickTables {
  const BrickLinks* links;
  const int32_t* begin;            ///< first node of each brick
  const uint64_t *nodes, *voxels;  ///< masks of nodes, and of voxels whose corner 0 they are
  const int32_t* first_voxel;      ///< of each brick
  int32_t bricks;

  __device__ int64_t slots() const { return int64_t(kSlots) * bricks; }
  __device__ bool has_node(int64_t slot) const { return is_in(nodes, slot); }
  __device__ bool has_voxel(int64_t slot) const { return is_in(voxels, slot); }
  /// Number of the node, or voxel, in a slot that has one.
  __device__ int32_t node(int64_t slot) const { return number(begin, nodes, slot); }
  __device__ int32_t voxel(int64_t slot) const { return number(first_voxel, voxels, slot); }

  /// The slot at x, y, z of a brick or of those `around` it, -8 to 15; -1 where there is none.
  __device__ int64_t slot_at(const int32_t around[27], int x, int y, int z) const {
    const int32_t brick = around[(x >> 3) + 1 + 3 * ((y >> 3) + 1) + 9 * ((z >> 3) + 1)];
    if (brick == bricks) return -1;
    return int64_t(kSlots) * brick + (x & 7) + 8 * ((y & 7) + 8 * (z & 7));
  }

  __device__ static bool is_in(const uint64_t* mask, int64_t slot) {
    return mask[slot >> 6] >> (slot & 63) & 1;
  }
  /// Number of a point of a mask, from that of the first one of each brick.
  __device__ static int32_t number(const int32_t* first, const uint64_t* mask, int64_t slot) {
    const int64_t word = slot >> 6;
    int32_t before = first[slot / kSlots];
    for (int64_t w = slot / kSlots * (kSlots / 64); w < word; ++w) before += __popcll(mask[w]);
    return before + __popcll(mask[word] & ((uint64_t{1} << (slot & 63)) - 1));
  }
};

/// Place of a slot in its brick.
struct Place {
  int x, y, z;
  __device__ explicit Place(int64_t slot)
      : x(int(slot % 8)), y(int(slot / 8 % 8)), z(int(slot / 64 % 8)) {}
};

class DeviceBricks {
 public:
  explicit DeviceBricks(const BrickLevel& level)
      : links(level.links), begin(level.brick_count() + 1) {
    std::vector<int32_t> first_node(size_t(level.brick_count()) + 1), first(first_node.size());
    std::vector<uint64_t> of_nodes(size_t(8 * level.brick_count())), of_voxels(of_nodes.size());
    for (int64_t b = 0; b < level.brick_count(); ++b) {
      first_node[size_t(b)] = int32_t(level.nodes.first(b));
      std::copy_n(level.nodes.mask(b).begin(), 8, of_nodes.begin() + 8 * b);
    }
    first_node.back() = int32_t(level.nodes.point_count());
    for (int64_t b = 0; b < level.voxels.brick_count(); ++b) {
      const int64_t node_brick = level.node_brick[size_t(b)];
      first[size_t(node_brick)] = int32_t(level.voxels.first(b));
      std::copy_n(level.voxels.mask(b).begin(), 8, of_voxels.begin() + 8 * node_brick);
    }
    begin.upload(first_node.data());
    if (MemoryCount::present()) return;
    nodes_ = DeviceArray<uint64_t>(of_nodes);
    voxels_ = DeviceArray<uint64_t>(of_voxels);
    first_voxel_ = DeviceArray<int32_t>(first);
  }

  BrickTables tables() const {
    return {links.data(),   begin.data(),        nodes_.data(),
            voxels_.data(), first_voxel_.data(), int32_t(links.size())};
  }

  // for owners that keep them
  DeviceArray<BrickLinks> links;
  DeviceArray<int32_t> begin;  ///< first node of each brick, (bricks + 1)

 private:
  DeviceArray<uint64_t> nodes_, voxels_;
  DeviceArray<int32_t> first_voxel_;
};

}  // namespace elastogen::cuda
