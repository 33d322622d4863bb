// SPDX-License-Identifier: Apache-2.0
// The encoder's corrections with an additional stiffness of some nodes, as in encoder.cpp, by three
// kernels: product_kernel projects the stiffness of a chunk of nodes onto the modes, sum_kernel
// adds the chunks of each piece, and correction_kernel adds the sum to A_r at rest and inverts it.
#include "core/cuda/inverse.cuh"
#include "network/precondition/encoder.cuh"

#include <algorithm>

namespace elastogen::cuda {
namespace {

constexpr int kModesOfNode = kEncoderModes, kWidth = 3 * kModesOfNode;
constexpr int kStiffChunk = 64;  // entries
constexpr int kThreads = 256;
constexpr int kSumWidth = 32, kSumSlices = 16;
// pairs of modes m >= n, times the six numbers of a symmetric block
constexpr int kProducts = 6 * kModesOfNode * (kModesOfNode + 1) / 2;

/// Index of the first product of modes m >= n.
__device__ int product_place(int m, int n) {
  return 6 * (m * (m + 1) / 2 + n);
}

/// products[chunk] = sum over its entries of mode m times mode n times the entry's block; one block
/// of threads for each chunk. It copies the stiffness of the entries into shared memory. If all of
/// it is 0, it only marks the chunk as not touched. Else it copies the modes too, and each thread
/// sums some of the kProducts numbers over the entries.
template <class Number>
__global__ void __launch_bounds__(kThreads)
    product_kernel(const EncoderChunk* chunks, const StiffEntry* entries, const double* blocks,
                   const Number* modes, double* products, int32_t* touched) {
  __shared__ double mode[kStiffChunk][kModesOfNode], block[kStiffChunk][6];
  const EncoderChunk chunk = chunks[blockIdx.x];
  const int count = chunk.end - chunk.begin, thread = int(threadIdx.x);
  // stiffness of the entries, and whether there is any
  bool stiff = false;
  for (int k = thread; k < 6 * count; k += kThreads) {
    const double value = blocks[6 * int64_t(entries[chunk.begin + k / 6].stiff) + k % 6];
    block[k / 6][k % 6] = value;
    stiff |= value != 0;
  }
  const int any = __syncthreads_or(stiff);
  if (thread == 0) touched[blockIdx.x] = any;
  if (!any) return;
  // modes of the entries
  for (int k = thread; k < kModesOfNode * count; k += kThreads)
    mode[k / kModesOfNode][k % kModesOfNode] =
        mode_value(modes[int64_t(entries[chunk.begin + k / kModesOfNode].node) * kModesOfNode +
                         k % kModesOfNode]);
  __syncthreads();
  // number k belongs to modes m >= n and number k % 6 of a block
  for (int k = thread; k < kProducts; k += kThreads) {
    int m = 0;
    while (product_place(m + 1, 0) <= k) ++m;
    const int n = (k - product_place(m, 0)) / 6;
    double sum = 0;
    for (int e = 0; e < count; ++e) sum += mode[e][m] * mode[e][n] * block[e][k % 6];
    products[int64_t(blockIdx.x) * kProducts + k] = sum;
  }
}

/// sums[piece] = sum of the products of its chunks. A block has kSumWidth numbers of a piece, and
/// kSumSlices threads for each: a slice of threads adds every kSumSlices-th chunk, then the sums of
/// the slices are added in order. Chunks that are not touched are skipped.
__global__ void __launch_bounds__(kSumWidth* kSumSlices)
    sum_kernel(const int32_t* begin, const int32_t* touched, const double* products, double* sums) {
  __shared__ double parts[kSumSlices][kSumWidth];
  const int64_t piece = blockIdx.y;
  const int x = int(threadIdx.x), slice = int(threadIdx.y), k = int(blockIdx.x) * kSumWidth + x;
  double sum = 0;
  for (int32_t c = begin[piece] + slice; c < begin[piece + 1]; c += kSumSlices)
    if (touched[c] != 0 && k < kProducts) sum += products[int64_t(c) * kProducts + k];
  parts[slice][x] = sum;
  __syncthreads();
  if (slice > 0 || k >= kProducts) return;
  double total = 0;
  for (int s = 0; s < kSumSlices; ++s) total += parts[s][x];
  sums[piece * kProducts + k] = total;
}

using ReducedTile = InverseTile<4>;
static_assert(kWidth <= ReducedTile::kRows);

/// A_r^-1 - s D_r^-1 for A_r = rest + sums, one block for each piece. The matrix, scaled to unit
/// diagonal, is spread over the registers of the block (InverseTile). The block inverts D_r, the
/// part of A_r within components, then A_r, and writes the difference with the scale undone.
__global__ void __launch_bounds__(ReducedTile::kThreads)
    correction_kernel(const double* rest, const double* sums, double known_share,
                      double* corrections) {
  __shared__ ReducedTile::Scratch scratch;
  __shared__ double scale[kWidth];
  const double* from = rest + int64_t(blockIdx.x) * kWidth * kWidth;
  const double* more = sums + int64_t(blockIdx.x) * kProducts;
  const auto full = [&](int a, int b) {
    const int m = a / 3, n = b / 3, place = symmetric_place(a % 3, b % 3);
    return (from[a * kWidth + b] + from[b * kWidth + a]) / 2 +
           more[product_place(m > n ? m : n, m > n ? n : m) + place];
  };
  const int thread = int(threadIdx.x) + ReducedTile::kWidth * int(threadIdx.y);
  // the scale to unit diagonal; 1e-9 is added below as on the host
  if (thread < kWidth) scale[thread] = 1 / sqrt(fmax(full(thread, thread), 1e-300));
  __syncthreads();
  const auto scaled = [&](int a, int b) {
    return scale[a] * full(a, b) * scale[b] + (a == b ? 1e-9 : 0);
  };
  ReducedTile known(kWidth, [&](int a, int b) { return a % 3 == b % 3 ? scaled(a, b) : 0; });
  known.invert(scratch);
  __syncthreads();
  ReducedTile tile(kWidth, scaled);
  tile.invert(scratch);
  double* to = corrections + int64_t(blockIdx.x) * kWidth * kWidth;
  tile.for_entries(known, [&](int a, int b, double value, double of_known) {
    if (a < kWidth && b < kWidth)
      to[a * kWidth + b] = scale[a] * (value - known_share * of_known) * scale[b];
  });
}

}  // namespace

template <class T>
void DeviceEncoder<T>::expect_stiffness(const std::vector<std::vector<int32_t>>& pieces,
                                        const std::vector<int32_t>& nodes) {
  std::vector<StiffEntry> entries;
  std::vector<EncoderChunk> chunks;
  std::vector<int32_t> begin;
  for (size_t p = 0; p < pieces.size(); ++p) {
    const std::vector<int32_t>& own = pieces[p];
    begin.push_back(int32_t(chunks.size()));
    const auto from = int32_t(entries.size());
    // both lists ascend
    for (size_t k = 0, s = 0; k < own.size() && s < nodes.size();) {
      if (own[k] == nodes[s]) entries.push_back({int32_t(s), modes_.first[p] + int32_t(k)});
      own[k] < nodes[s] ? ++k : ++s;
    }
    const auto end = int32_t(entries.size());
    for (int32_t at = from; at < end; at += kStiffChunk)
      chunks.push_back({int32_t(p), at, std::min(at + kStiffChunk, end)});
  }
  std::vector<double> rest;
  for (const ReducedOperator& of : operators_)
    rest.insert(rest.end(), of.rest.begin(), of.rest.end());
  rest.resize(size_t(corrections_.size()));
  begin.push_back(int32_t(chunks.size()));
  rest_ = DeviceArray<double>(rest);
  stiff_ = DeviceArray<StiffEntry>(entries);
  stiff_chunks_ = DeviceArray<EncoderChunk>(chunks);
  stiff_begin_ = DeviceArray<int32_t>(begin);
  products_ = DeviceArray<double>((stiff_chunks_.size() + piece_count()) * kProducts);
  touched_ = DeviceArray<int32_t>(stiff_chunks_.size());
  stiff_corrections_ = DeviceArray<double>(corrections_.size());
}

template <class T>
void DeviceEncoder<T>::set_nodal_stiffness(const NodalStiffness& stiffness) {
  const int64_t pieces = piece_count(), chunks = stiff_chunks_.size();
  if (pieces == 0) return;
  double *of_chunks = products_.data(), *of_pieces = of_chunks + chunks * kProducts;
  if (chunks > 0 && stiffness.count > 0)
    product_kernel<<<unsigned(chunks), kThreads>>>(stiff_chunks_.data(), stiff_.data(),
                                                   stiffness.blocks, modes_.values.data(),
                                                   of_chunks, touched_.data());
  check(cudaGetLastError());
  // without stiffness the sums are 0
  constexpr unsigned kBlocks = (kProducts + kSumWidth - 1) / kSumWidth;
  if (stiffness.count > 0)
    sum_kernel<<<dim3(kBlocks, unsigned(pieces)), dim3(kSumWidth, kSumSlices)>>>(
        stiff_begin_.data(), touched_.data(), of_chunks, of_pieces);
  else
    check(cudaMemsetAsync(of_pieces, 0, size_t(pieces * kProducts) * sizeof(double),
                          cudaStreamPerThread));
  check(cudaGetLastError());
  constexpr dim3 kSquare(ReducedTile::kWidth, ReducedTile::kWidth);
  const double known = operators_.empty() ? 0 : operators_[0].known;
  correction_kernel<<<unsigned(pieces), kSquare>>>(rest_.data(), of_pieces, known,
                                                   stiff_corrections_.data());
  check(cudaGetLastError());
}

template void DeviceEncoder<float>::expect_stiffness(const std::vector<std::vector<int32_t>>&,
                                                     const std::vector<int32_t>&);
template void DeviceEncoder<double>::expect_stiffness(const std::vector<std::vector<int32_t>>&,
                                                      const std::vector<int32_t>&);
template void DeviceEncoder<float>::set_nodal_stiffness(const NodalStiffness&);
template void DeviceEncoder<double>::set_nodal_stiffness(const NodalStiffness&);

}  // namespace elastogen::cuda
