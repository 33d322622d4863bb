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

/// First in every kernel that launch() starts: lets the next one start as soon as there is room,
/// and waits for those before. What comes ahead of it may only read what no kernel writes.
__device__ inline void begin_kernel() {
  cudaTriggerProgrammaticLaunchCompletion();
  cudaGridDependencySynchronize();
}

/// Launches on the default stream a kernel that calls begin_kernel(): its blocks start while the
/// kernel before is ending, which hides most of what a launch costs.
template <class... Parameters, class... Arguments>
void launch(void (*kernel)(Parameters...), dim3 blocks, dim3 threads, size_t shared_bytes,
            const Arguments&... arguments) {
  cudaLaunchAttribute attribute{};
  attribute.id = cudaLaunchAttributeProgrammaticStreamSerialization;
  attribute.val.programmaticStreamSerializationAllowed = 1;
  cudaLaunchConfig_t config{};
  config.gridDim = blocks;
  config.blockDim = threads;
  config.dynamicSmemBytes = shared_bytes;
  config.attrs = &attribute;
  config.numAttrs = 1;
  check(cudaLaunchKernelEx(&config, kernel, Parameters(arguments)...));
}

template <class Body>
__global__ void for_each_kernel(int64_t n, Body body) {
  begin_kernel();
  const int64_t i = int64_t(blockIdx.x) * blockDim.x + threadIdx.x;
  if (i < n) body(i);
}

/// body(i) for each i of [0, n).
template <class Body>
void for_each(int64_t n, const Body& body) {
  constexpr int kThreads = 256;
  if (n == 0) return;
  launch(for_each_kernel<Body>, unsigned((n + kThreads - 1) / kThreads), kThreads, 0, n, body);
}

}  // namespace elastogen::cuda
