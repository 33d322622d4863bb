// SPDX-License-Identifier: Apache-2.0
// A_r at rest as sums of outer products of vectors over the modes. d_a are the gradients of a
// voxel's modes along the axes, q_k their centred patterns (encoder_operator.hpp); lambda, mu and c
// include the voxel's weight. The blocks of A_r that couple components i and j are
//
//     A_ij = sum lambda d_i d_j^T + mu d_j d_i^T + mu/48 q_a q_b^T,              i < j,
//     A_ii = sum (mu + lambda) d_i d_i^T + (2 mu - 2 c_a)/48 q_a q_a^T + E,
//     E    = sum mu sum_a d_a d_a^T + sum_k c'_k/48 q_k q_k^T + sum inertia b b^T,
//
// c' = 2 c (c for xyz), a and b the patterns across i and j.
#include "network/potential/incremental_potential.cuh"
#include "network/precondition/encoder.cuh"
#include "network/precondition/encoder_operator.cuh"

namespace elastogen::cuda {
namespace {

constexpr int kModes = kEncoderModes, kSize = kReducedSize;
constexpr int kSide = 8, kFour = 4;                    // modes and voxels of a product
constexpr int kGroups = (kModes + kSide - 1) / kSide;  // of modes
constexpr int kBlocks = 264;                           // on every card: one order of sums
constexpr int kWarp = 32, kStreams = 2;                // pairs of warps, each with its own voxels
constexpr int kThreads = 2 * kStreams * kWarp;
constexpr int kLayers = 4, kSlabs = kLanes / kLayers;  // layers of a slab, slabs of a brick
constexpr int kWidth = ::elastogen::bricks::kTileWidth, kPlane = kWidth * kWidth;
constexpr int kNodes = kPlane * (kLayers + 1), kEntries = kNodes + 1;  // the last one is none
constexpr int kRows = kLanes * kLayers, kSlots = kRows * kLanes;       // at a time

// sums, kSide x kSide each: across for each pair of components, within for each component and E;
// those within are symmetric: a group of columns has the rows of its own group and of the next
constexpr int kE = 3, kAcross = 3 * kGroups * kGroups, kWithin = (kE + 1) * kGroups * 2;
constexpr int kMost = kAcross > kWithin ? kAcross : kWithin;
constexpr int kNumbers = (kAcross + kWithin) * kSide * kSide;

/// The next of three axes or groups; also the index of the centred pattern across an axis.
ELASTOGEN_HD constexpr int next(int k) {
  return (k + 1) % 3;
}

/// Index of the sum across components i < j for group r of rows and group c of columns.
ELASTOGEN_HD constexpr int across_sum(int i, int j, int r, int c) {
  return ((i + j - 1) * kGroups + c) * kGroups + r;
}

/// Index of the sum within component i or E, for r = c or r = next(c).
ELASTOGEN_HD constexpr int within_sum(int i, int r, int c) {
  return (i * kGroups + c) * 2 + (r != c);
}

// fields of a voxel in shared memory; phi h and the factors of the products are in the weights
constexpr int kMu = 0, kLambda = 1, kVariance = 2, kMoments = 6, kFields = 12;

struct Scratch {
  double mode[kEntries * kModes];  ///< groups go beyond the last mode of a node
  double field[kFields][kSlots];
  int32_t entry[kEntries];  ///< of the slab's nodes; -1: not in the piece
  int32_t place[kSlots];    ///< of voxels in the slab; -1: none
};
// add_outer, add_square, store_sums and add_inertia rely on this
static_assert(kGroups == 3 && kStreams * kNumbers <= kNodes * kModes && kSlots < kEntries);

template <class T>
struct PieceOnDevice {
  DeviceModes<T> modes;
  int32_t first, end;
};

/// Finds the entries of a slab that begins at a place of its brick's tile; true if there are any.
/// All threads of the block must call this function and those below.
template <class T>
__device__ bool find_entries(const RowsView& g, const PieceOnDevice<T>& piece, int64_t brick,
                             int begin, Scratch& work) {
  constexpr int kOfThread = (::elastogen::bricks::kTile + kThreads - 1) / kThreads;
  for (int k = int(threadIdx.x); k < kEntries; k += kThreads) work.entry[k] = -1;
  int32_t place[kOfThread], entry[kOfThread];
  const int32_t first = g.tile_begin[brick], last = g.tile_begin[brick + 1];
#pragma unroll
  for (int j = 0; j < kOfThread; ++j) {
    const int32_t k = first + int32_t(threadIdx.x) + j * kThreads;
    place[j] = k < last ? g.tile_place[k] - begin : -1;
    entry[j] = k < last ? piece.modes.entry[g.tile_node[k]] : -1;
  }
  __syncthreads();
  bool found = false;
#pragma unroll
  for (int j = 0; j < kOfThread; ++j)
    if (place[j] >= 0 && place[j] < kNodes && entry[j] >= piece.first && entry[j] < piece.end)
      work.entry[place[j]] = entry[j], found = true;
  return __syncthreads_or(found);
}

/// Copies the modes of the entries, 0 where there are none; kSide threads read an entry.
template <class Number>
__device__ void read_modes(const Number* modes, Scratch& work) {
  constexpr int kAtOnce = 13, kStep = kThreads / kSide;
  const int mode = int(threadIdx.x) % kSide;
  for (int first = int(threadIdx.x) / kSide; first < kEntries; first += kAtOnce * kStep) {
    int32_t entry[kAtOnce];
    Number value[kAtOnce][kGroups];
#pragma unroll
    for (int j = 0; j < kAtOnce; ++j) {
      entry[j] = work.entry[min(first + j * kStep, kEntries - 1)];
      const Number* from = modes + int64_t(max(entry[j], 0)) * kModes + mode;
      for (int g = 0; g < kGroups; ++g)
        value[j][g] = from[mode + g * kSide < kModes ? g * kSide : 0];
    }
#pragma unroll
    for (int j = 0; j < kAtOnce; ++j)
      for (int g = 0; g < kGroups; ++g)
        if (first + j * kStep < kEntries && mode + g * kSide < kModes)
          work.mode[(first + j * kStep) * kModes + mode + g * kSide] =
              entry[j] < 0 ? 0 : double(mode_value(value[j][g]));
  }
}

/// Sets weights and moments of a voxel.
__device__ inline void set_fields(const VoxelTables<double>& voxels, const VoxelRow& row, int64_t r,
                                  int lane, double field[kFields]) {
  const double* weights = voxels.weights + r * 5 * kLanes + lane;
  const LawParameters<double>& law = voxels.materials[row.material].law;
  const double scale = weights[0] * voxels.h;
  field[kMu] = scale * law.mu / 16;
  field[kLambda] = scale * law.lambda / 16;
  for (int k = 0; k < 4; ++k) {
    const double c = (k < 3 ? 2 : 1) * weights[(k + 1) * kLanes] * (1.0 / 48);
    field[kVariance + k] = voxels.hourglass == Hourglass::kOff ? 0 : scale * c;
  }
  for (int p = 1; p < 7; ++p)
    field[kMoments + p - 1] =
        row.border < 0 ? 0 : voxels.border[(int64_t(row.border) * 7 + p) * kLanes + lane];
}

/// Reads the slab's voxels of the piece in kRows rows; true if there are any.
__device__ inline bool read_voxels(const RowsView& g, const VoxelTables<double>& voxels,
                                   int32_t first_row, int32_t row_end, int begin, Scratch& work) {
  bool found = false;
  for (int slot = int(threadIdx.x); slot < kSlots; slot += kThreads) {
    const int32_t r = first_row + slot / kLanes;
    const int lane = slot % kLanes;
    const VoxelRow row = bricks::row_at(g, r, row_end);
    const int place = row.offset + lane - begin;
    const bool there = (row.mask >> lane & 1) != 0 && place >= 0 && place < kPlane * kLayers &&
                       work.entry[place] >= 0;
    double field[kFields] = {};
    if (there) set_fields(voxels, row, r, lane, field);
    for (int k = 0; k < kFields; ++k) work.field[k][slot] = field[k];
    work.place[slot] = there ? place : -1;
    found |= there;
  }
  return __syncthreads_or(found);
}

// Products of four voxels, sum += a[row] b[column]: thread 4 row + k of the warp has a[row] and
// b[row] of voxel k, and the sums of that row and the columns 2 k and 2 k + 1. An instruction for
// eight rows lasts as long as one for sixteen.
__device__ inline void add_product(double (&sum)[2], double a, double b) {
  asm volatile("mma.sync.aligned.m8n8k4.row.col.f64.f64.f64.f64 {%0, %1}, {%2}, {%3}, {%0, %1};"
               : "+d"(sum[0]), "+d"(sum[1])
               : "d"(a), "d"(b));
}

__device__ inline void add_products(double (&upper)[2], double (&lower)[2], double a_upper,
                                    double a_lower, double b) {
  asm volatile(
      "mma.sync.aligned.m16n8k4.row.col.f64.f64.f64.f64 "
      "{%0, %1, %2, %3}, {%4, %5}, {%6}, {%0, %1, %2, %3};"
      : "+d"(upper[0]), "+d"(upper[1]), "+d"(lower[0]), "+d"(lower[1])
      : "d"(a_upper), "d"(a_lower), "d"(b));
}

/// d and q of a voxel for one mode of each group.
struct VoxelModes {
  double d[3][kGroups], q[4][kGroups];
};

/// @param corner  mode of the first group at corner 0.
/// @param M       moments of the fill, M[0] unused.
ELASTOGEN_HD inline VoxelModes voxel_modes(const double* corner, const double M[7]) {
  VoxelModes result;
  for (int g = 0; g < kGroups; ++g) {
    double v[8], d[3], q[4];
    for (int c = 0; c < 8; ++c) {
      const int node = (c & 1) + (c & 2 ? kWidth : 0) + (c & 4 ? kPlane : 0);
      v[c] = corner[node * kModes + g * kSide];
    }
    hex8::to_patterns(v);
    hex8::gradient<true>(v, M, d);
    hex8::centred_patterns<true>(v, M, q);
    for (int a = 0; a < 3; ++a) result.d[a][g] = d[a];
    for (int k = 0; k < 4; ++k) result.q[k][g] = q[k];
  }
  return result;
}

/// The sums of a warp: those across components or those within.
using WarpSums = double[kMost][2];

/// Adds weight a b^T to the sum of components i < j.
__device__ inline void add_outer(int i, int j, double weight, const double a[kGroups],
                                 const double b[kGroups], WarpSums& sum) {
#pragma unroll
  for (int c = 0; c < kGroups; ++c) {
    const double weighted = weight * b[c];
    const int first = across_sum(i, j, 0, c);
    add_products(sum[first], sum[first + 1], a[0], a[1], weighted);
    add_product(sum[first + 2], a[2], weighted);
  }
}

/// Adds weight a a^T to the sum of component i, or to E.
__device__ inline void add_square(int i, double weight, const double a[kGroups], WarpSums& sum) {
#pragma unroll
  for (int c = 0; c < kGroups; ++c) {
    const int first = within_sum(i, c, c);
    add_products(sum[first], sum[first + 1], a[c], a[next(c)], weight * a[c]);
  }
}

/// Adds a voxel's products across components; `twisting` is 1 with the torsion term, else 0.
__device__ inline void add_across(const VoxelModes& v, const Scratch& work, int slot,
                                  double twisting, WarpSums& sum) {
  const double mu = work.field[kMu][slot], lambda = work.field[kLambda][slot];
  const double torsion = twisting * mu * (1.0 / 3);
#pragma unroll
  for (int i = 0; i < 3; ++i)
#pragma unroll
    for (int j = i + 1; j < 3; ++j) {
      add_outer(i, j, lambda, v.d[i], v.d[j], sum);
      add_outer(i, j, mu, v.d[j], v.d[i], sum);
      add_outer(i, j, torsion, v.q[next(i)], v.q[next(j)], sum);
    }
}

/// Adds a voxel's products within components.
__device__ inline void add_within(const VoxelModes& v, const Scratch& work, int slot,
                                  double twisting, WarpSums& sum) {
  const double mu = work.field[kMu][slot], both = mu + work.field[kLambda][slot];
#pragma unroll
  for (int i = 0; i < 3; ++i) {
    const double variance = work.field[kVariance + next(i)][slot];
    add_square(i, both, v.d[i], sum);
    add_square(kE, mu, v.d[i], sum);
    add_square(i, twisting * (mu * (2.0 / 3) - variance), v.q[next(i)], sum);
    add_square(kE, variance, v.q[next(i)], sum);
  }
  add_square(kE, work.field[kVariance + 3][slot], v.q[3], sum);
}

/// Adds the voxels in shared memory that belong to a warp's stream.
__device__ inline void add_voxels(const Scratch& work, double twisting, bool across, int stream,
                                  WarpSums& sum) {
  const int thread = int(threadIdx.x) % kWarp;
#pragma unroll 1
  for (int four = 0; four < kSlots / kStreams; four += kFour) {
    const int row = four / kLanes * kStreams + stream;
    const int slot = row * kLanes + four % kLanes + thread % kFour;
    const int place = work.place[slot];
    if (!__any_sync(~0u, place >= 0)) continue;
    double M[7];
    for (int p = 1; p < 7; ++p) M[p] = work.field[kMoments + p - 1][slot];
    const double* corner = work.mode + (place < 0 ? 0 : place) * kModes + thread / kFour;
    const VoxelModes v = voxel_modes(corner, M);
    across ? add_across(v, work, slot, twisting, sum) : add_within(v, work, slot, twisting, sum);
  }
}

/// Adds the inertia of the piece's nodes to E, kSlots entries at a time.
template <class T>
__device__ void add_inertia(const PieceOnDevice<T>& piece, const double* inertia, Scratch& work,
                            bool across, int stream, WarpSums& sum) {
  const int thread = int(threadIdx.x) % kWarp;
  for (int64_t first = piece.first + int64_t(blockIdx.x) * kSlots; first < piece.end;
       first += int64_t(kBlocks) * kSlots) {
    for (int k = int(threadIdx.x); k < kEntries; k += kThreads) {
      const bool there = k < kSlots && first + k < piece.end;
      work.entry[k] = there ? int32_t(first + k) : -1;
      if (k < kSlots) work.field[kMu][k] = there ? inertia[piece.modes.nodes[first + k]] : 0;
    }
    __syncthreads();
    read_modes(piece.modes.modes, work);
    __syncthreads();
#pragma unroll 1
    for (int four = stream * kFour; four < kSlots && !across; four += kStreams * kFour) {
      const double weight = work.field[kMu][four + thread % kFour];
      const double* mode = work.mode + (four + thread % kFour) * kModes + thread / kFour;
      double b[kGroups];
      for (int g = 0; g < kGroups; ++g) b[g] = mode[g * kSide];
      add_square(kE, weight, b, sum);
    }
    __syncthreads();
  }
}

/// Stores the sums of a block, adding those of the streams in order.
__device__ inline void store_sums(const WarpSums& sum, bool across, int stream, Scratch& work,
                                  double* partial) {
  const int thread = int(threadIdx.x) % kWarp, count = across ? kAcross : kWithin;
  double* mine = work.mode + stream * kNumbers + (across ? 0 : kAcross * kSide * kSide);
#pragma unroll
  for (int k = 0; k < kMost; ++k)
    for (int i = 0; i < 2 && k < count; ++i) mine[k * kSide * kSide + 2 * thread + i] = sum[k][i];
  __syncthreads();
  for (int k = int(threadIdx.x); k < kNumbers; k += kThreads) {
    double total = 0;
    for (int s = 0; s < kStreams; ++s) total += work.mode[s * kNumbers + k];
    partial[int64_t(blockIdx.x) * kNumbers + k] = total;
  }
}

/// Sums of every kBlocks-th slab (kLayers layers of a brick) and of part of the nodes, (blocks,
/// kNumbers). The modes of a slab's nodes and the fields of its voxels go to shared memory. Tensor
/// cores multiply four voxels at a time, eight modes by eight: each thread finds d and q of one
/// voxel for one mode of each group, just those that it feeds to them, so these stay in registers,
/// as do the sums. Half of the warps have the sums across components, the others those within.
template <class T>
__global__ void __launch_bounds__(kThreads, 2)
    rest_kernel(RowsView g, VoxelTables<double> voxels, const double* inertia,
                PieceOnDevice<T> piece, double* partial) {
  extern __shared__ __align__(16) unsigned char bytes[];
  Scratch& work = *reinterpret_cast<Scratch*>(bytes);
  const int stream = int(threadIdx.x) / kWarp % kStreams;
  const bool across = threadIdx.x < kThreads / 2;
  const double twisting = voxels.hourglass == Hourglass::kFull ? 1 : 0;
  double sum[kMost][2] = {};
  begin_kernel();
  // elastic terms: slabs with nodes of the piece, kRows rows at a time
  for (int64_t slab = blockIdx.x; slab < g.bricks * kSlabs; slab += kBlocks) {
    const int64_t brick = slab / kSlabs;
    const int begin = int(slab % kSlabs) * kLayers * kPlane;
    if (!find_entries(g, piece, brick, begin, work)) continue;
    read_modes(piece.modes.modes, work);
    const int32_t row_end = g.row_begin[brick + 1];
    for (int32_t row = g.row_begin[brick]; row < row_end; row += kRows) {
      if (!read_voxels(g, voxels, row, row_end, begin, work)) continue;
      add_voxels(work, twisting, across, stream, sum);
      __syncthreads();
    }
  }
  // inertia, then the block's sums
  add_inertia(piece, inertia, work, across, stream, sum);
  store_sums(sum, across, stream, work, partial);
}

/// A_r from the sums of all blocks.
std::vector<double> assembled(const std::vector<double>& sums) {
  const auto at = [&](int sum, int m, int n) {
    return sums[size_t((sum * kSide + m % kSide) * kSide + n % kSide)];
  };
  const auto across = [&](int i, int j, int m, int n) {
    return at(across_sum(i, j, m / kSide, n / kSide), m, n);
  };
  const auto within = [&](int i, int m, int n) {
    const int r = m / kSide, c = n / kSide;
    const bool there = r == c ? m >= n : r == next(c);
    return there ? at(kAcross + within_sum(i, r, c), m, n)
                 : at(kAcross + within_sum(i, c, r), n, m);
  };
  // the upper triangle as summed, the lower one by symmetry
  std::vector<double> A(size_t(kSize) * kSize);
  for (int m = 0; m < kModes; ++m)
    for (int i = 0; i < 3; ++i)
      for (int n = 0; n < kModes; ++n)
        for (int j = 0; j < 3; ++j) {
          double& a = A[size_t((3 * m + i) * kSize + 3 * n + j)];
          if (i == j) a = within(i, m, n) + within(kE, m, n);
          if (i < j) a = across(i, j, m, n);
          if (i > j) a = across(j, i, n, m);
        }
  return A;
}

}  // namespace

template <class T>
std::vector<double> reduced_rest_operator(DevicePotential& potential, const DeviceModes<T>& modes,
                                          int32_t first, int32_t end) {
  const DevicePotential::Impl& impl = potential.impl();
  DeviceArray<double> partial(int64_t(kBlocks) * kNumbers), total(kNumbers);
  double *const from = partial.data(), *const to = total.data();
  check(cudaFuncSetAttribute(rest_kernel<T>, cudaFuncAttributeMaxDynamicSharedMemorySize,
                             int(sizeof(Scratch))));
  launch(rest_kernel<T>, kBlocks, kThreads, sizeof(Scratch), impl.rows.view(),
         impl.voxels<double>(), impl.inertia.data(), PieceOnDevice<T>{modes, first, end}, from);
  cuda::for_each(kNumbers, [=] __device__(int64_t k) {
    double sum = 0;
    for (int64_t block = 0; block < kBlocks; ++block) sum += from[block * kNumbers + k];
    to[k] = sum;
  });
  std::vector<double> sums(kNumbers);
  total.download(sums.data());
  return assembled(sums);
}

template std::vector<double> reduced_rest_operator(DevicePotential&, const DeviceModes<float>&,
                                                   int32_t, int32_t);
template std::vector<double> reduced_rest_operator(DevicePotential&, const DeviceModes<double>&,
                                                   int32_t, int32_t);

}  // namespace elastogen::cuda
