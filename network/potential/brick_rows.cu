// SPDX-License-Identifier: Apache-2.0
// The tables of make_brick_rows, made on the device from masks of voxels and nodes. Kernels count
// the entries of each brick, the host adds the counts up, then each brick writes its own entries.
// The host uploads fill, variance weights and materials of all voxels, moments of border voxels.
#include "core/hex8.hpp"
#include "network/potential/brick_rows.cuh"

#include <climits>
#include <numeric>

namespace elastogen::cuda {
namespace {

constexpr int kTilePlaces = ::elastogen::bricks::kTile;
constexpr int kThreads = 768, kWarps = kThreads / 32;  // one thread for each place of a tile
static_assert(kTilePlaces <= kThreads && kSlots <= kThreads);

/// The border voxels, which are not full, listed by bricks of nodes.
struct BorderVoxels {
  BorderVoxels(const VoxelGrid& grid, const BrickLevel& level)
      : masks(size_t(8 * level.brick_count())), first(size_t(level.brick_count()) + 1) {
    const BrickIndex& voxels = level.voxels;
    const auto in_bricks = [&](const auto& body) {
      ::elastogen::for_each(
          voxels.brick_count(),
          [&](int64_t b) {
            const int64_t end =
                b + 1 < voxels.brick_count() ? voxels.first(b + 1) : voxels.point_count();
            for (int64_t v = voxels.first(b); v < end; ++v) body(level.node_brick[size_t(b)], v);
          },
          1);
    };
    // mark and count border voxels
    in_bricks([&](int32_t brick, int64_t v) {
      if (is_full(grid, v)) return;
      const int32_t* at = grid.voxel_coord.row(v);
      masks[size_t(8 * brick + (at[2] & 7))] |= uint64_t{1} << ((at[0] & 7) + 8 * (at[1] & 7));
      ++first[size_t(brick) + 1];
    });
    std::partial_sum(first.begin(), first.end(), first.begin());
    moments.resize(6 * size_t(first.back()));
    std::vector<int32_t> next(first.begin(), first.end() - 1);
    if (moments.empty()) return;
    // their moments in the order of the bricks
    in_bricks([&](int32_t brick, int64_t v) {
      const int32_t* at = grid.voxel_coord.row(v);
      if (!(masks[size_t(8 * brick + (at[2] & 7))] >> ((at[0] & 7) + 8 * (at[1] & 7)) & 1)) return;
      double M[7];
      hex8::fill_moments(grid.shape_mean.row(v), M);
      std::copy_n(M + 1, 6, moments.begin() + 6 * int64_t(next[size_t(brick)]++));
    });
  }

  std::vector<uint64_t> masks;
  std::vector<int32_t> first;  // first border voxel of each brick, then their count
  Zeroed<double> moments;      // M_1 ... M_6 of each border voxel
};

/// Tables of voxels by their number, and of border voxels by theirs.
struct VoxelSource {
  const int32_t* material;  ///< null: all have the first one
  const double *fill, *variance;
  const uint64_t* border;  ///< masks; null: all are full
  const int32_t* first_border;
  const double* moments;
};

/// The voxels on a line of eight places along x.
struct VoxelLine {
  const int32_t* material;
  int32_t first;  ///< number of its first voxel
  unsigned voxels, border;

  __device__ VoxelLine(const BrickTables& g, const VoxelSource& source, int64_t slot)
      : material(source.material) {
    const int shift = int(slot & 56);
    voxels = unsigned(g.voxels[slot >> 6] >> shift) & 0xff;
    border = source.border ? unsigned(source.border[slot >> 6] >> shift) & 0xff : 0;
    first = g.voxel(slot & ~int64_t{7});
  }
  __device__ bool has(int lane) const { return voxels >> lane & 1; }
  __device__ int32_t voxel(int lane) const { return first + __popc(voxels & ((1u << lane) - 1)); }
  __device__ int32_t material_of(int lane) const { return material ? material[voxel(lane)] : 0; }
  /// The lanes of a material.
  __device__ unsigned lanes_of(int32_t m) const {
    if (!material) return voxels;
    unsigned lanes = 0;
    for (int l = 0; l < kLanes; ++l) lanes |= unsigned(has(l) && material_of(l) == m) << l;
    return lanes;
  }
  /// Adds the count of rows of materials below m, and of those rows that have border voxels.
  __device__ void count_rows(int32_t m, int& rows, int& borders) const {
    for (int l = 0; l < kLanes; ++l) {
      if (!has(l) || material_of(l) >= m) continue;
      const unsigned lanes = lanes_of(material_of(l));
      if (__ffs(int(lanes)) - 1 != l) continue;  // counted before
      ++rows;
      borders += (lanes & border) != 0;
    }
  }
};

/// Sum over the threads before this one, and over all. @param scratch  shared memory, (kWarps)
__device__ int sum_before(int value, int* scratch, int& total) {
  const int lane = int(threadIdx.x) % 32, warp = int(threadIdx.x) / 32;
  const int warps = int(blockDim.x) / 32;
  int sum = value;
  for (int step = 1; step < 32; step *= 2) {
    const int below = __shfl_up_sync(~0u, sum, step);
    if (lane >= step) sum += below;
  }
  __syncthreads();  // earlier sums may still be read
  if (lane == 31) scratch[warp] = sum;
  __syncthreads();
  int before = sum - value;
  total = 0;
  for (int w = 0; w < warps; ++w) {
    if (w < warp) before += scratch[w];
    total += scratch[w];
  }
  return before;
}

/// Whether a place of a brick's tile is a corner of one of its voxels.
__device__ bool is_corner(const BrickTables& g, int64_t brick, int place) {
  if (place >= kTilePlaces) return false;
  const int x = place % 9, y = place / 9 % 9, z = place / 81;
  for (int c = 0; c < 8; ++c) {
    const int at[3] = {x - (c & 1), y - (c >> 1 & 1), z - (c >> 2)};
    if (at[0] < 0 || at[0] > 7 || at[1] < 0 || at[1] > 7 || at[2] < 0 || at[2] > 7) continue;
    if (g.has_voxel(kSlots * brick + at[0] + 8 * (at[1] + 8 * at[2]))) return true;
  }
  return false;
}

/// Count of the bricks below `limit` that hold a node.
__device__ int holders(const BrickTables& g, int64_t slot, int32_t limit) {
  const Place at(slot);
  // one for each side of the planes between bricks on which the node lies
  const int planes = (at.x == 0) | (at.y == 0) << 1 | (at.z == 0) << 2;
  const int32_t* around = g.links[slot / kSlots].neighbour;
  unsigned sides = 0;
  for (int c = 0; c < 8; ++c) {
    const int64_t v = g.slot_at(around, at.x - (c & 1), at.y - (c >> 1 & 1), at.z - (c >> 2));
    if (v >= 0 && v / kSlots < limit && g.has_voxel(v)) sides |= 1u << (c & planes);
  }
  return __popc(sides);
}

/// Count of a node's partial sums, 0 where one brick alone holds it.
__device__ int part_count(const BrickTables& g, int64_t slot) {
  if (!g.has_node(slot)) return 0;
  const int count = holders(g, slot, INT_MAX);
  return count > 1 ? count : 0;
}

/// Counts rows, rows with border voxels and tile entries, [kind][brick]; one block for each brick
/// of voxels, a thread for each place of its tile. The first 64 threads count the rows of one line
/// of voxels each, all threads test whether their place is a corner; then the block adds up.
__global__ void __launch_bounds__(kThreads)
    count_kernel(BrickTables g, VoxelSource source, const int32_t* brick_of, int32_t* counts) {
  __shared__ int scratch[kWarps];
  begin_kernel();
  const int64_t brick = brick_of[blockIdx.x];
  const int t = int(threadIdx.x);
  int number[3] = {};
  if (t < kSlots / kLanes)
    VoxelLine(g, source, kSlots * brick + kLanes * t).count_rows(INT_MAX, number[0], number[1]);
  number[2] = is_corner(g, brick, t);
  for (int kind = 0; kind < 3; ++kind) {
    int total;
    sum_before(number[kind], scratch, total);
    if (t == 0) counts[int64_t(kind) * gridDim.x + blockIdx.x] = total;
  }
}

/// Writes rows, weights of their voxels and moments of border voxels; one block for each brick, a
/// thread for each voxel. First one thread for each line counts its rows, and sums over the threads
/// before give where the line's rows begin. Within a line, rows are in the order of materials. The
/// first lane of a row writes the row, each thread the data of its voxel.
__global__ void __launch_bounds__(kSlots)
    row_kernel(BrickTables g, VoxelSource source, const int32_t* brick_of, const int32_t* row_begin,
               const int32_t* border_begin, VoxelRow* rows, double* weights, double* moments) {
  constexpr int kLinesOfBrick = kSlots / kLanes;
  __shared__ int scratch[kWarps], row_of[kLinesOfBrick], border_of[kLinesOfBrick];
  begin_kernel();
  const int t = int(threadIdx.x), lane = t % kLanes, line = t / kLanes;
  const int64_t first = kSlots * int64_t(brick_of[blockIdx.x]);
  // first row, and first row with border voxels, of each line
  int count = 0, borders = 0, total;
  if (t < kLinesOfBrick)
    VoxelLine(g, source, first + kLanes * t).count_rows(INT_MAX, count, borders);
  const int before = sum_before(count, scratch, total);
  const int borders_before = sum_before(borders, scratch, total);
  if (t < kLinesOfBrick) row_of[t] = before, border_of[t] = borders_before;
  __syncthreads();
  const VoxelLine voxels(g, source, first + kLanes * line);
  if (!voxels.has(lane)) return;
  // row of this voxel, behind those of smaller materials
  const int32_t v = voxels.voxel(lane), material = voxels.material_of(lane);
  int row = row_begin[blockIdx.x] + row_of[line];
  int border = border_begin[blockIdx.x] + border_of[line];
  voxels.count_rows(material, row, border);
  const unsigned lanes = voxels.lanes_of(material);
  const bool has_border = (lanes & voxels.border) != 0;
  if (__ffs(int(lanes)) - 1 == lane)
    rows[row] = {
        ::elastogen::bricks::kTileWidth * (line % 8 + ::elastogen::bricks::kTileWidth * (line / 8)),
        material, has_border ? border : -1, lanes};
  double* const weight = weights + int64_t(5 * kLanes) * row + lane;
  weight[0] = source.fill[v];
  for (int k = 0; k < 4; ++k) weight[(k + 1) * kLanes] = source.variance[4 * int64_t(v) + k];
  if (!(voxels.border >> lane & 1)) return;
  const int32_t number = BrickTables::number(source.first_border, source.border, first + t);
  for (int p = 1; p < 7; ++p)
    moments[(int64_t(border) * 7 + p) * kLanes + lane] =
        source.moments[6 * int64_t(number) + p - 1];
}

/// Nodes that several bricks of voxels hold, and their partial sums; one block for each brick of
/// nodes, a thread for each slot. Without a list of nodes they are only counted, else written
/// behind those of earlier bricks.
__global__ void __launch_bounds__(kSlots)
    shared_kernel(BrickTables g, int32_t* counts, const int32_t* shared_first,
                  const int32_t* part_first, int32_t* shared_node, int32_t* shared_begin,
                  int32_t* first_part) {
  __shared__ int scratch[kWarps];
  begin_kernel();
  const int64_t slot = int64_t(kSlots) * blockIdx.x + threadIdx.x;
  const int parts = part_count(g, slot);
  int shared_total, part_total;
  const int shared = sum_before(parts > 0, scratch, shared_total);
  const int part = sum_before(parts, scratch, part_total);
  if (shared_node == nullptr) {
    if (threadIdx.x == 0)
      counts[blockIdx.x] = shared_total, counts[gridDim.x + blockIdx.x] = part_total;
    return;
  }
  if (parts == 0) return;
  const int32_t n = g.node(slot), first = part_first[blockIdx.x] + part;
  shared_node[shared_first[blockIdx.x] + shared] = n;
  shared_begin[shared_first[blockIdx.x] + shared] = first;
  first_part[n] = 1 + first;
}

/// Entries of a brick's tile, by one block; threads whose place is a corner count those before
/// them. A brick's partial sum of a node lies behind those of the bricks before it.
/// @param first_part  1 + index of each node's first partial sum, 0 where there is none.
__global__ void __launch_bounds__(kThreads)
    tile_kernel(BrickTables g, const int32_t* brick_of, const int32_t* tile_begin,
                const int32_t* first_part, int32_t* tile_node, int16_t* tile_place,
                int32_t* tile_part) {
  __shared__ int scratch[kWarps];
  begin_kernel();
  const int32_t brick = brick_of[blockIdx.x];
  const int place = int(threadIdx.x);
  const bool there = is_corner(g, brick, place);
  int total;
  const int before = sum_before(there, scratch, total);
  if (!there) return;
  const int64_t slot = g.slot_at(g.links[brick].neighbour, place % 9, place / 9 % 9, place / 81);
  const int32_t n = g.node(slot), entry = tile_begin[blockIdx.x] + before, first = first_part[n];
  tile_node[entry] = n;
  tile_place[entry] = int16_t(place);
  tile_part[entry] = first == 0 ? -1 : first - 1 + holders(g, slot, brick);
}

/// The sum of the counts before each one, then the sum of all.
std::vector<int32_t> summed(const int32_t* counts, int64_t size) {
  std::vector<int32_t> result(size_t(size) + 1);
  std::partial_sum(counts, counts + size, result.begin() + 1);
  return result;
}

template <class Vector>
void fetch(const DeviceArray<typename Vector::value_type>& from, Vector& to) {
  to.resize(size_t(from.size()));
  from.download(to.data());
}

}  // namespace

struct DeviceRows::Bricks {
  explicit Bricks(const BrickLevel& of)
      : level(of), on_device(of), brick_of(of.node_brick), nodes(of.nodes.point_count()) {}

  const BrickLevel& level;
  DeviceBricks on_device;
  DeviceArray<int32_t> brick_of;
  int64_t nodes;
};

DeviceRows::DeviceRows(const Scene& scene, const BrickLevel& level) {
  if (MemoryCount::present()) {
    count(make_brick_rows(scene));
    return;
  }
  const Bricks bricks(level);
  make_rows(scene, bricks);
  make_tiles(bricks);
}

/// Counts the memory of these tables, which are not made.
void DeviceRows::count(const BrickRows& g) {
  rows_ = DeviceArray<VoxelRow>(g.row_count());
  row_begin_ = DeviceArray<int32_t>(int64_t(g.row_begin.size()));
  tile_begin_ = DeviceArray<int32_t>(int64_t(g.tile_begin.size()));
  tile_node_ = DeviceArray<int32_t>(int64_t(g.tile_node.size()));
  tile_part_ = DeviceArray<int32_t>(tile_node_.size());
  tile_place_ = DeviceArray<int16_t>(tile_node_.size());
  shared_node_ = DeviceArray<int32_t>(int64_t(g.shared_node.size()));
  shared_begin_ = DeviceArray<int32_t>(int64_t(g.shared_begin.size()));
  weights_ = DeviceArray<double>(g.row_count() * 5 * kLanes);
  border_ = DeviceArray<double>(int64_t(g.border.size()));
  parts_ = g.shared_begin.back();
}

void DeviceRows::make_rows(const Scene& scene, const Bricks& bricks) {
  const VoxelGrid& grid = scene.grid;
  const BorderVoxels border(grid, bricks.level);
  const bool borders = !border.moments.empty();
  const DeviceArray<uint64_t> masks(borders ? border.masks : std::vector<uint64_t>());
  const DeviceArray<int32_t> first_border(borders ? border.first : std::vector<int32_t>());
  const DeviceArray<double> moments(border.moments);
  const DeviceArray<double> fill(grid.fill.data(), grid.fill.size());
  const DeviceArray<double> variance(scene.variance.data(), scene.variance.size());
  const DeviceArray<int32_t> material(scene.material.data(),
                                      scene.materials.size() > 1 ? scene.material.size() : 0);
  const VoxelSource source{material.data(), fill.data(),         variance.data(),
                           masks.data(),    first_border.data(), moments.data()};
  const BrickTables g = bricks.on_device.tables();
  // counts of each brick, added up
  const int64_t count = bricks.brick_of.size();
  DeviceArray<int32_t> counts(3 * count);
  launch(count_kernel, unsigned(count), kThreads, 0, g, source, bricks.brick_of.data(),
         counts.data());
  std::vector<int32_t> found;
  fetch(counts, found);
  const std::vector<int32_t> rows = summed(found.data(), count);
  const std::vector<int32_t> of_border = summed(found.data() + count, count);
  row_begin_ = DeviceArray<int32_t>(rows);
  const std::vector<int32_t> entries = summed(found.data() + 2 * count, count);
  tile_begin_ = DeviceArray<int32_t>(entries);
  tile_node_ = DeviceArray<int32_t>(entries.back());
  tile_place_ = DeviceArray<int16_t>(entries.back());
  tile_part_ = DeviceArray<int32_t>(entries.back());
  rows_ = DeviceArray<VoxelRow>(rows.back());
  weights_ = DeviceArray<double>(rows_.size() * 5 * kLanes);
  border_ = DeviceArray<double>(int64_t(of_border.back()) * 7 * kLanes);
  // each brick writes its rows
  const DeviceArray<int32_t> border_begin(of_border);
  launch(row_kernel, unsigned(count), kSlots, 0, g, source, bricks.brick_of.data(),
         row_begin_.data(), border_begin.data(), rows_.data(), weights_.data(), border_.data());
  synchronise();
}

void DeviceRows::make_tiles(const Bricks& bricks) {
  const BrickTables g = bricks.on_device.tables();
  DeviceArray<int32_t> counts(2 * int64_t(g.bricks)), first_part(bricks.nodes);
  const int32_t* const none = nullptr;
  int32_t* const nowhere = nullptr;
  launch(shared_kernel, unsigned(g.bricks), kSlots, 0, g, counts.data(), none, none, nowhere,
         nowhere, nowhere);
  std::vector<int32_t> found;
  fetch(counts, found);
  const std::vector<int32_t> shared = summed(found.data(), g.bricks);
  const std::vector<int32_t> parts = summed(found.data() + g.bricks, g.bricks);
  parts_ = parts.back();
  shared_node_ = DeviceArray<int32_t>(shared.back());
  shared_begin_ = DeviceArray<int32_t>(shared.back() + 1);
  shared_begin_.upload(&parts.back(), shared.back(), 1);
  // nodes that several bricks hold, then the tiles
  if (shared.back() > 0) {
    const DeviceArray<int32_t> shared_first(shared), part_first(parts);
    launch(shared_kernel, unsigned(g.bricks), kSlots, 0, g, nowhere, shared_first.data(),
           part_first.data(), shared_node_.data(), shared_begin_.data(), first_part.data());
    synchronise();
  }
  launch(tile_kernel, unsigned(bricks.brick_of.size()), kThreads, 0, g, bricks.brick_of.data(),
         tile_begin_.data(), first_part.data(), tile_node_.data(), tile_place_.data(),
         tile_part_.data());
  synchronise();
}

BrickRows DeviceRows::download() const {
  BrickRows g;
  fetch(rows_, g.rows);
  fetch(row_begin_, g.row_begin);
  fetch(tile_begin_, g.tile_begin);
  fetch(tile_node_, g.tile_node);
  fetch(tile_place_, g.tile_place);
  fetch(tile_part_, g.tile_part);
  fetch(shared_node_, g.shared_node);
  fetch(shared_begin_, g.shared_begin);
  fetch(border_, g.border);
  return g;
}

}  // namespace elastogen::cuda
