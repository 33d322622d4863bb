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

// In every kernel that launch() starts, first of all and then before anything is read that another
// kernel writes or written that another one reads: what comes between them runs beside the kernels
// before.

/// Lets the next kernel start as soon as there is room.
__device__ inline void let_next_start() {
  cudaTriggerProgrammaticLaunchCompletion();
}
/// Waits for the kernels before.
__device__ inline void wait_for_before() {
  cudaGridDependencySynchronize();
}
/// Both at once.
__device__ inline void begin_kernel() {
  let_next_start();
  wait_for_before();
}

/// Where a kernel is launched, and when its blocks start: early, while the kernel before is ending,
/// or where it waits for an event, after all that it waits for.
struct Line {
  cudaStream_t stream = cudaStreamPerThread;
  bool early = true;

  cudaLaunchAttribute attribute() const {
    cudaLaunchAttribute result{};
    result.id = cudaLaunchAttributeProgrammaticStreamSerialization;
    result.val.programmaticStreamSerializationAllowed = early;
    return result;
  }
};

/// Launches a kernel that calls begin_kernel(); blocks that start early hide most of what a launch
/// costs.
template <class... Parameters, class... Arguments>
void launch_on(const Line& line, void (*kernel)(Parameters...), dim3 blocks, dim3 threads,
               size_t shared_bytes, const Arguments&... arguments) {
  cudaLaunchAttribute attribute = line.attribute();
  cudaLaunchConfig_t config{};
  config.gridDim = blocks;
  config.blockDim = threads;
  config.dynamicSmemBytes = shared_bytes;
  config.stream = line.stream;
  config.attrs = &attribute;
  config.numAttrs = 1;
  check(cudaLaunchKernelEx(&config, kernel, Parameters(arguments)...));
}

/// The same early, on the stream of the thread.
template <class... Parameters, class... Arguments>
void launch(void (*kernel)(Parameters...), dim3 blocks, dim3 threads, size_t shared_bytes,
            const Arguments&... arguments) {
  launch_on(Line{}, kernel, blocks, threads, shared_bytes, arguments...);
}

template <class Body>
__global__ void for_each_kernel(int64_t n, Body body) {
  begin_kernel();
  const int64_t i = int64_t(blockIdx.x) * blockDim.x + threadIdx.x;
  if (i < n) body(i);
}

/// body(i) for each i of [0, n).
template <class Body>
void for_each(int64_t n, const Body& body, const Line& line = {}) {
  constexpr int kThreads = 256;
  if (n == 0) return;
  launch_on(line, for_each_kernel<Body>, unsigned((n + kThreads - 1) / kThreads), kThreads, 0, n,
            body);
}

}  // namespace elastogen::cuda
