// SPDX-License-Identifier: Apache-2.0
// Launches of kernels, one thread for each item, on the stream of the thread (cudaStreamPerThread)
// unless LaunchOptions name another stream.

#pragma once

#include "core/error.hpp"

#include <cstdint>
#include <type_traits>

namespace elastogen::cuda {

/// @throws Error (resources) unless a call went well.
inline void check(cudaError_t error) {
  if (error == cudaSuccess) return;
  cudaGetLastError();  // cleared, so that no later call reports it again
  throw Error(concat("CUDA: ", cudaGetErrorString(error)), ErrorKind::kResources);
}

// Every kernel started by launch() calls let_next_start() and wait_for_before(). The first comes as
// early as is useful; a block that exits implies it. The second comes before the first access to
// memory that an earlier kernel writes; only read_early() may come before it. Code above the wait
// runs at the same time as earlier kernels. Such a kernel must not use __ldg: its loads count as
// constant, and may be moved ahead of the wait.

/// Lets the next kernel start as soon as multiprocessors have space for its blocks.
__device__ inline void let_next_start() {
  cudaTriggerProgrammaticLaunchCompletion();
}
/// Waits for the earlier kernels.
__device__ inline void wait_for_before() {
  cudaGridDependencySynchronize();
}
/// Both calls at once.
__device__ inline void begin_kernel() {
  let_next_start();
  wait_for_before();
}

/// Reads before the wait, from tables that the host knows to be complete. It reads from the L2
/// cache: until the wait the L1 cache of the multiprocessor may have old contents of the memory.
template <class T>
__device__ inline T read_early(const T* from) {
  using Word = std::conditional_t<alignof(T) % sizeof(int4) == 0, int4,
                                  std::conditional_t<alignof(T) % sizeof(int) == 0, int, short>>;
  static_assert(sizeof(T) % sizeof(Word) == 0 && alignof(T) % alignof(Word) == 0);
  struct Words {
    Word word[sizeof(T) / sizeof(Word)];
  } words;
#pragma unroll
  for (size_t k = 0; k < sizeof(T) / sizeof(Word); ++k)
    words.word[k] = __ldcg(reinterpret_cast<const Word*>(from) + k);
  return __builtin_bit_cast(T, words);
}

/// Blocks that start early crowd on the multiprocessors that are free first; if they are few, some
/// multiprocessors get several and others none. The kernel before one with this many blocks or
/// fewer therefore lets it start only at its end.
inline constexpr int kFewBlocks = 1024;

/// The stream of a launch, and when its blocks start: early, while the kernel before is ending, or
/// only after all that it waits for, as a launch behind an event must.
struct LaunchOptions {
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
void launch_on(const LaunchOptions& options, void (*kernel)(Parameters...), dim3 blocks,
               dim3 threads, size_t shared_bytes, const Arguments&... arguments) {
  cudaLaunchAttribute attribute = options.attribute();
  cudaLaunchConfig_t config{};
  config.gridDim = blocks;
  config.blockDim = threads;
  config.dynamicSmemBytes = shared_bytes;
  config.stream = options.stream;
  config.attrs = &attribute;
  config.numAttrs = 1;
  check(cudaLaunchKernelEx(&config, kernel, Parameters(arguments)...));
}

/// launch_on the stream of the thread, early.
template <class... Parameters, class... Arguments>
void launch(void (*kernel)(Parameters...), dim3 blocks, dim3 threads, size_t shared_bytes,
            const Arguments&... arguments) {
  launch_on(LaunchOptions{}, kernel, blocks, threads, shared_bytes, arguments...);
}

template <class Body>
__global__ void for_each_kernel(int64_t n, bool late, Body body) {
  if (!late) let_next_start();
  wait_for_before();
  const int64_t i = int64_t(blockIdx.x) * blockDim.x + threadIdx.x;
  if (i < n) body(i);
}

/// Calls body(i) for each i of [0, n), one thread for each.
/// @param late  the next kernel starts when this one ends (kFewBlocks).
template <class Body>
void for_each(int64_t n, const Body& body, const LaunchOptions& options = {}, bool late = false) {
  constexpr int kThreads = 256;
  if (n == 0) return;
  launch_on(options, for_each_kernel<Body>, unsigned((n + kThreads - 1) / kThreads), kThreads, 0, n,
            late, body);
}

}  // namespace elastogen::cuda
