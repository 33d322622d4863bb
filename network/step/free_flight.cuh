// SPDX-License-Identifier: Apache-2.0
// The free pieces of a scene, which nothing holds, on the device: sums over the nodes of each piece
// in a fixed order, and its motion as a whole (predictor.hpp, free_flight.hpp).

#pragma once

#include "core/cuda/reduce.cuh"
#include "core/polar.hpp"
#include "core/scene.hpp"

namespace elastogen::cuda {

/// A range of entries in the list of all pieces' nodes; all of them belong to one piece.
struct PieceChunk {
  int32_t piece, begin, end;
};

/// The tables of the pieces, as kernels read them.
struct PiecesView {
  const int32_t *nodes, *chunk_begin, *first;
  const PieceChunk* chunks;
  const double *rest_centre, *per_mass;
};

/// Centre of mass and mean rotation of a piece.
struct PieceFrame {
  double centre[3];
  Mat3<double> rotation;
};

namespace pieces {

/// Calls body(piece, node) for every entry, one block for each chunk.
template <class Body>
__global__ void __launch_bounds__(kSumThreads) entries_kernel(PiecesView g, Body body) {
  const PieceChunk chunk = g.chunks[blockIdx.x];
  for (int k = chunk.begin + int(threadIdx.x); k < chunk.end; k += kSumThreads)
    body(int64_t(chunk.piece), int64_t(g.nodes[k]));
}

/// partial[chunk] = sum of body(piece, node, sum) over the entries of a chunk, one block for each.
template <class Sum, class Body>
__global__ void __launch_bounds__(kSumThreads) chunk_kernel(PiecesView g, Sum* partial, Body body) {
  alignas(Sum) __shared__ unsigned char all[kSumWarps * sizeof(Sum)];
  const PieceChunk chunk = g.chunks[blockIdx.x];
  Sum mine;
  for (int k = chunk.begin + int(threadIdx.x); k < chunk.end; k += kSumThreads)
    body(int64_t(chunk.piece), int64_t(g.nodes[k]), mine);
  const Sum sum = block_sum(mine, reinterpret_cast<Sum*>(all));
  if (threadIdx.x == 0) partial[blockIdx.x] = sum;
}

/// Calls then(piece, sum of its chunks), one block for each piece.
template <class Sum, class Then>
__global__ void __launch_bounds__(kSumThreads)
    piece_kernel(PiecesView g, const Sum* partial, Then then) {
  alignas(Sum) __shared__ unsigned char all[kSumWarps * sizeof(Sum)];
  const int64_t p = blockIdx.x;
  const int64_t first = g.chunk_begin[p], count = g.chunk_begin[p + 1] - first;
  const Sum sum = detail::sum_of_partials(
      count, [&](int64_t k) { return partial[first + k]; }, reinterpret_cast<Sum*>(all));
  if (threadIdx.x == 0) then(p, sum);
}

}  // namespace pieces

class DevicePieces {
 public:
  /// The scene must be complete.
  explicit DevicePieces(const Scene& scene);

  int64_t count() const { return first_.size(); }
  PiecesView view() const {
    return {nodes_.data(),  chunk_begin_.data(), first_.data(),
            chunks_.data(), rest_centre_.data(), per_mass_.data()};
  }

  /// Calls body(piece, node) for every node of a free piece.
  template <class Body>
  void for_each(const Body& body) const {
    if (count() == 0) return;
    pieces::entries_kernel<<<unsigned(chunks_.size()), kSumThreads>>>(view(), body);
    check(cudaGetLastError());
  }

  /// Adds body(piece, node, sum) over the nodes of each piece, then calls then(piece, sum).
  template <class Sum, class Body, class Then>
  void sums(DeviceArray<Sum>& partial, const Body& body, const Then& then) {
    if (count() == 0) return;
    pieces::chunk_kernel<<<unsigned(chunks_.size()), kSumThreads>>>(view(), partial.data(), body);
    check(cudaGetLastError());
    pieces::piece_kernel<<<unsigned(count()), kSumThreads>>>(view(), partial.data(), then);
    check(cudaGetLastError());
  }

  /// As FreeFlight::match_means; aim(k) is the aim of the number k = 3 node + component.
  template <class Aim>
  void match_means(const double* mass, double* values, const Aim& aim) {
    const PiecesView g = view();
    double* shift = shift_.data();
    sums(
        excess_,
        [=] __device__(int64_t, int64_t n, Sums<3> & sum) {
          for (int i = 0; i < 3; ++i)
            sum.value[i] += mass[n] * (values[3 * n + i] - aim(3 * n + i));
        },
        [=] __device__(int64_t p, const Sums<3>& sum) {
          for (int i = 0; i < 3; ++i) shift[3 * p + i] = sum.value[i] * g.per_mass[p];
        });
    for_each([=] __device__(int64_t p, int64_t n) {
      for (int i = 0; i < 3; ++i) values[3 * n + i] -= shift[3 * p + i];
    });
  }

  /// Sets u of the free pieces at the start of a step; other nodes keep theirs.
  /// @param x, x_before, predictor  of all nodes, on the device; predictor is xhat - rest.
  void start(const double* rest, const double* mass, const double* x, const double* x_before,
             const double* predictor, double* u);

  /// Finds the frames of the pieces, (pieces), with number k = 3 node + component at position(k).
  template <class Position>
  void find_frames(const double* rest, const double* mass, const Position& position,
                   PieceFrame* frames);

 private:
  DeviceArray<int32_t> nodes_;        // of all pieces, one after the other
  DeviceArray<PieceChunk> chunks_;    // in the order of the pieces
  DeviceArray<int32_t> chunk_begin_;  // first chunk of each piece, (pieces + 1)
  DeviceArray<int32_t> first_;        // first node of each piece
  DeviceArray<double> rest_centre_;   // of mass [m], (pieces, 3)
  DeviceArray<double> per_mass_;      // [1/kg]
  DeviceArray<double> shift_;         // of match_means, (pieces, 3)
  DeviceArray<Sums<3>> excess_;       // of the chunks
  DeviceArray<Sums<12>> moments_;     // of the chunks
  DeviceArray<PieceFrame> frames_;    // now, before and next, (3, pieces)
};

}  // namespace elastogen::cuda
