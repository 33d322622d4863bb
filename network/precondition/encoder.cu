// SPDX-License-Identifier: Apache-2.0
#include "network/precondition/encoder.cuh"

#include <algorithm>
#include <limits>

namespace elastogen::cuda {
namespace {

// the numbers of a piece or a chunk are ordered as 3 mode + component
constexpr int kModes = kEncoderModes, kSize = kReducedSize;
constexpr int kChunk = 1024;                               // entries
constexpr int kGroups = 32;                                // thread groups of a chunk
constexpr int kSlices = 16;                                // thread slices of a piece
constexpr int kColumns = (kSize + kSlices - 1) / kSlices;  // of the correction, of a slice
constexpr int kTile = 128;                                 // entries that a block decodes

/// B^T r of a chunk, one block for each chunk. The block first gathers r of the chunk's nodes into
/// shared memory. It has kGroups groups of kModes threads, a thread for each mode: group g adds the
/// entries g, g + kGroups, ..., so that the block reads consecutive modes. Then one thread for each
/// of the kSize numbers adds the sums of the groups in order.
template <class T>
__global__ void __launch_bounds__(kModes* kGroups)
    encode_kernel(const EncoderChunk* chunks, const int32_t* nodes, const ModeNumber<T>* modes,
                  const T* r, T* partial) {
  __shared__ T value[3 * kChunk], sums[kGroups][kSize];
  begin_kernel();
  const EncoderChunk chunk = chunks[blockIdx.x];
  const int entries = chunk.end - chunk.begin, mode = int(threadIdx.x), group = int(threadIdx.y);
  const int thread = group * kModes + mode;
  for (int k = thread; k < 3 * entries; k += kModes * kGroups)
    value[k] = r[3 * int64_t(nodes[chunk.begin + k / 3]) + k % 3];
  __syncthreads();
  const ModeNumber<T>* first = modes + int64_t(chunk.begin) * kModes + mode;
  T sum[3] = {};
  for (int k = group; k < entries; k += kGroups) {
    const T weight = mode_value(first[k * kModes]);
    for (int i = 0; i < 3; ++i) sum[i] += weight * value[3 * k + i];
  }
  for (int i = 0; i < 3; ++i) sums[group][3 * mode + i] = sum[i];
  __syncthreads();
  if (thread >= kSize) return;
  T total = 0;
  for (int g = 0; g < kGroups; ++g) total += sums[g][thread];
  partial[int64_t(blockIdx.x) * kSize + thread] = total;
}

/// Sum of a column of `sums`, in the order of the slices.
__device__ inline double sum_of_slices(const double sums[kSlices][kSize], int column) {
  double total = 0;
#pragma unroll
  for (int s = 0; s < kSlices; ++s) total += sums[s][column];
  return total;
}

/// The correction times B^T r of a piece in float64, one block for each piece. It has kSlices
/// slices of kSize threads, a thread for each row. A thread loads every kSlices-th column of its
/// row of the correction into registers, then adds every kSlices-th chunk of B^T r. The sums of the
/// slices, added in order, are B^T r in shared memory. Each slice multiplies its columns with it,
/// and the sums of the slices are again added in order.
template <class T>
__global__ void __launch_bounds__(kSize* kSlices)
    solve_kernel(const int32_t* chunk_begin, const T* partial, const double* corrections,
                 double* solution) {
  __shared__ double sums[kSlices][kSize], reduced[kSize];
  const int64_t piece = blockIdx.x;
  const int row = int(threadIdx.x), slice = int(threadIdx.y);
  begin_kernel();
  const double* matrix = corrections + piece * kSize * kSize + row;
  // this slice's columns of the correction
  double column[kColumns];
#pragma unroll
  for (int k = 0; k < kColumns; ++k)
    column[k] = slice + k * kSlices < kSize ? matrix[(slice + k * kSlices) * kSize] : 0;
  // B^T r of the piece
  const int32_t end = chunk_begin[piece + 1];
  double sum = 0;
#pragma unroll 8
  for (int c = chunk_begin[piece] + slice; c < end; c += kSlices)
    sum += double(partial[int64_t(c) * kSize + row]);
  sums[slice][row] = sum;
  __syncthreads();
  if (slice == 0) reduced[row] = sum_of_slices(sums, row);
  __syncthreads();
  // the correction times it
  double product = 0;
#pragma unroll
  for (int k = 0; k < kColumns; ++k)
    if (slice + k * kSlices < kSize) product += column[k] * reduced[slice + k * kSlices];
  sums[slice][row] = product;
  __syncthreads();
  if (slice == 0) solution[piece * kSize + row] = sum_of_slices(sums, row);
}

/// z = B y on kTile entries of a chunk, one thread for each entry. Grid (chunks, parts of a chunk).
/// The block copies the coefficients y of the piece and the modes of its entries into shared memory
/// first: consecutive threads then read consecutive modes, though each needs all modes of one
/// entry.
template <class T>
__global__ void __launch_bounds__(kTile)
    decode_kernel(const EncoderChunk* chunks, const int32_t* nodes, const ModeNumber<T>* modes,
                  const double* solution, T* z) {
  __shared__ T mode[kTile * kModes], coefficient[kSize];
  begin_kernel();
  const EncoderChunk chunk = chunks[blockIdx.x];
  const int32_t begin = chunk.begin + int32_t(blockIdx.y) * kTile;
  const int entries = min(kTile, chunk.end - begin), thread = int(threadIdx.x);
  if (entries <= 0) return;
  if (thread < kSize) coefficient[thread] = T(solution[int64_t(chunk.piece) * kSize + thread]);
  for (int k = thread; k < entries * kModes; k += kTile)
    mode[k] = mode_value(modes[int64_t(begin) * kModes + k]);
  __syncthreads();
  if (thread >= entries) return;
  T sum[3] = {};
  for (int m = 0; m < kModes; ++m)
    for (int i = 0; i < 3; ++i) sum[i] += mode[thread * kModes + m] * coefficient[3 * m + i];
  T* value = z + 3 * int64_t(nodes[begin + thread]);
  for (int i = 0; i < 3; ++i) value[i] = sum[i];
}

/// A_r at rest of all pieces.
template <class T>
std::vector<ReducedOperator> rest_operators(DevicePotential& potential,
                                            const PieceModesOnDevice<T>& modes) {
  DeviceArray<int32_t> entry(potential.nodes());
  check(cudaMemsetAsync(entry.data(), 0xff, size_t(entry.size()) * sizeof(int32_t),
                        cudaStreamPerThread));
  const int32_t* const node = modes.nodes.data();
  int32_t* const entry_of = entry.data();
  cuda::for_each(modes.nodes.size(), [=] __device__(int64_t k) { entry_of[node[k]] = int32_t(k); });
  const DeviceModes<T> of{modes.values.data(), node, entry_of};
  std::vector<ReducedOperator> operators;
  const double known = known_share(potential.terms().scene());
  for (size_t p = 0; p + 1 < modes.first.size(); ++p)
    operators.emplace_back(reduced_rest_operator(potential, of, modes.first[p], modes.first[p + 1]),
                           known);
  return operators;
}

}  // namespace

template <class T>
DeviceEncoder<T>::DeviceEncoder(DevicePotential& potential,
                                const std::vector<std::vector<int32_t>>& pieces)
    : modes_(make_modes<T>(potential, pieces)) {
  // chunks of at most kChunk entries, piece by piece
  std::vector<int32_t> chunk_begin;
  std::vector<EncoderChunk> chunks;
  for (size_t p = 0; p < pieces.size(); ++p) {
    chunk_begin.push_back(int32_t(chunks.size()));
    const int32_t end = modes_.first[p + 1];
    for (int32_t begin = modes_.first[p]; begin < end; begin += kChunk)
      chunks.push_back({int32_t(p), begin, std::min(begin + kChunk, end)});
  }
  chunk_begin.push_back(int32_t(chunks.size()));
  // tables, and the memory that apply() works in
  chunks_ = DeviceArray<EncoderChunk>(chunks);
  chunk_begin_ = DeviceArray<int32_t>(chunk_begin);
  partial_ = DeviceArray<T>(chunks_.size() * kSize);
  solution_ = DeviceArray<double>(piece_count() * kSize);
  corrections_ = DeviceArray<double>(piece_count() * kSize * kSize);
  if (MemoryCount::present()) return;
  operators_ = rest_operators(potential, modes_);
  std::vector<double> corrections;
  // the operators at rest, and their corrections column by column
  for (const ReducedOperator& of : operators_)
    for (int column = 0; column < kSize; ++column)
      for (int row = 0; row < kSize; ++row)
        corrections.push_back(of.correction[size_t(row * kSize + column)]);
  corrections_.upload(corrections.data());
}

template <class T>
double DeviceEncoder<T>::softness() const {
  if (operators_.empty() && piece_count() > 0) return std::numeric_limits<double>::infinity();
  double softest = 1;
  for (const ReducedOperator& of : operators_) softest = std::max(softest, of.softness());
  return softest;
}

template <class T>
void DeviceEncoder<T>::apply(const T* r, T* z, cudaStream_t stream) {
  if (piece_count() == 0) return;
  const unsigned chunks = unsigned(chunks_.size()), pieces = unsigned(piece_count());
  const DeviceArray<double>& corrections = use_stiffness_ ? stiff_corrections_ : corrections_;
  const LaunchOptions first{stream, false}, next{stream};
  launch_on(first, encode_kernel<T>, chunks, dim3(kModes, kGroups), 0, chunks_.data(),
            modes_.nodes.data(), modes_.values.data(), r, partial_.data());
  launch_on(next, solve_kernel<T>, pieces, dim3(kSize, kSlices), 0, chunk_begin_.data(),
            partial_.data(), corrections.data(), solution_.data());
  launch_on(next, decode_kernel<T>, dim3(chunks, kChunk / kTile), kTile, 0, chunks_.data(),
            modes_.nodes.data(), modes_.values.data(), solution_.data(), z);
}

/// With twice the inertia A_r differs by its part in it.
template <class T>
void DeviceEncoder<T>::expect_inertia(DevicePotential& potential) {
  std::vector<double> inertia;
  if (!MemoryCount::present()) {
    const StepScheme built = potential.terms().scheme();
    StepScheme doubled = built;
    doubled.a0 *= 2;
    potential.set_scheme(doubled);
    const std::vector<ReducedOperator> more = rest_operators(potential, modes_);
    potential.set_scheme(built);
    for (size_t p = 0; p < more.size(); ++p)
      for (size_t k = 0; k < more[p].rest.size(); ++k)
        inertia.push_back(more[p].rest[k] - operators_[p].rest[k]);
  }
  inertia.resize(size_t(corrections_.size()));
  inertia_ = DeviceArray<double>(inertia);
  std::vector<double> rest;
  for (const ReducedOperator& of : operators_)
    rest.insert(rest.end(), of.rest.begin(), of.rest.end());
  rest.resize(inertia.size());
  built_ = DeviceArray<double>(rest);
}

template <class T>
void DeviceEncoder<T>::scale_inertia(double ratio) {
  const double *built = built_.data(), *inertia = inertia_.data();
  double* const rest = rest_.data();
  cuda::for_each(rest_.size(),
                 [=] __device__(int64_t k) { rest[k] = built[k] + (ratio - 1) * inertia[k]; });
}

template class DeviceEncoder<float>;
template class DeviceEncoder<double>;

}  // namespace elastogen::cuda
