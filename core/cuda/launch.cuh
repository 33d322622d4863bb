// SPDX-License-Identifier: Apache-2.0
// Launches of kernels, one thread an item: on the stream of the thread (cudaStreamPerThread) unless
// a Line names another.

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
// memory that an earlier kernel writes; only read_early() may come before it. What stands above the
// wait runs beside the kernels before. No __ldg in such a kernel: what it loads is taken for
// constant, and loaded ahead of the wait.

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

/// What is read before the wait, of tables that the host has seen done. It comes from the cache of
/// the card: until the wait that of the multiprocessor may hold what the memory had been before.
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

/// Blocks that start early crowd on the multiprocessors that are free first: of a few some then
/// have several and others none. The kernel before one of so few or fewer lets it start at its end
/// alone.
inline constexpr int kFewBlocks = 1024;

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
__global__ void for_each_kernel(int64_t n, bool late, Body body) {
  if (!late) let_next_start();
  wait_for_before();
  const int64_t i = int64_t(blockIdx.x) * blockDim.x + threadIdx.x;
  if (i < n) body(i);
}

/// body(i) for each i of [0, n).
/// @param late  the next kernel starts when this one ends (kFewBlocks).
template <class Body>
void for_each(int64_t n, const Body& body, const Line& line = {}, bool late = false) {
  constexpr int kThreads = 256;
  if (n == 0) return;
  launch_on(line, for_each_kernel<Body>, unsigned((n + kThreads - 1) / kThreads), kThreads, 0, n,
            late, body);
}

}  // namespace elastogen::cuda
