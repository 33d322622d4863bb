// SPDX-License-Identifier: Apache-2.0
// One thread an item, on the default stream, which is that of libtorch too.

#pragma once

#include "core/error.hpp"

#include <cstdint>

namespace elastogen::cuda {

/// @throws Error (resources) unless a call went well.
inline void check(cudaError_t error) {
  if (error == cudaSuccess) return;
  cudaGetLastError();  // cleared, so that no later call reports it again
  throw Error(concat("CUDA: ", cudaGetErrorString(error)), ErrorKind::kResources);
}

template <class Body>
__global__ void for_each_kernel(int64_t n, Body body) {
  const int64_t i = int64_t(blockIdx.x) * blockDim.x + threadIdx.x;
  if (i < n) body(i);
}

/// body(i) for each i of [0, n).
template <class Body>
void for_each(int64_t n, const Body& body) {
  constexpr int kThreads = 256;
  if (n == 0) return;
  for_each_kernel<<<unsigned((n + kThreads - 1) / kThreads), kThreads>>>(n, body);
  check(cudaGetLastError());
}

}  // namespace elastogen::cuda
