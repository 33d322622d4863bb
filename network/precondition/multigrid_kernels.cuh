// SPDX-License-Identifier: Apache-2.0
// The kernels of the V-cycle (multigrid.cu): a pass over a level, the residual of a coarser level, and
// the small levels by one cluster of blocks.

#pragma once

#include "network/precondition/stencil_pass.cuh"

#include <cooperative_groups.h>

namespace elastogen::cuda {

// nodes of a thread; a brick has 512 / kRun threads: long runs cost least where bricks fill the
// card, short ones end sooner
inline constexpr int kLongRun = 4, kShortRun = 2, kSingleRun = 1;
inline constexpr int kShortBricks = 512;   // of levels with short runs
inline constexpr int kSingleBricks = 128;  // of levels with one node a thread
inline constexpr int kClusterBricks = 16;  // of levels in the cluster, one for each block
inline constexpr int kClusterThreads = stencil::kSlots / kSingleRun;
inline constexpr int kRestrictThreads = 256;

/// The levels for a kernel, 0 the finest.
template <class T>
struct LevelViews {
  StencilView<T> level[kMostLevels];
  int count;
};

/// A pass over a level (stencil_pass.cuh), one block for each brick
template <class T, int kRun, bool kAdded>
__global__ void __launch_bounds__(stencil::kSlots / kRun,
                                  sizeof(T) == 4 && kRun > kSingleRun ? 2 * kRun : 1)
    pass_kernel(const __grid_constant__ StencilView<T> v, Pass pass, ResultOutput<T> out,
                bool late) {
  extern __shared__ __align__(16) unsigned char scratch[];
  if (!late) let_next_start();
  stencil::run_pass<T, kRun, kAdded>(v, pass, blockIdx.x, reinterpret_cast<T*>(scratch), out,
                                     [] { wait_for_before(); });
}

/// r of a level from the partial sums of the finer one, one thread for each slot
template <class T>
__global__ void __launch_bounds__(kRestrictThreads)
    restrict_kernel(const T* partial, const __grid_constant__ StencilView<T> coarse) {
  let_next_start();
  const int slot = int(blockIdx.x) * kRestrictThreads + int(threadIdx.x);
  const Restriction from(coarse.links, coarse.row, slot);
  wait_for_before();
  from.set(partial, coarse, slot);
}

/// Calls body(k) for each k of [0, n), shared out to the threads of the grid.
template <class Body>
__device__ void share_out(int n, const Body& body) {
  for (int k = int(blockIdx.x * blockDim.x + threadIdx.x); k < n; k += int(gridDim.x * blockDim.x))
    body(k);
}

template <class T, bool kAdded>
__device__ void cluster_pass(const StencilView<T>& v, Pass pass, const ResultOutput<T>& out) {
  extern __shared__ __align__(16) unsigned char scratch[];
  for (int32_t brick = int32_t(blockIdx.x); brick < v.bricks; brick += int32_t(gridDim.x)) {
    stencil::run_pass<T, kSingleRun, kAdded>(v, pass, brick, reinterpret_cast<T*>(scratch), out,
                                             [] {});
    __syncthreads();
  }
  cooperative_groups::this_cluster().sync();
}

/// The levels from `first` down to the coarsest and back, by one cluster of blocks, which share out
/// bricks and slots; its barriers take the place of launches. `out` is the result of level 0.
template <class T, bool kAdded>
__global__ void __launch_bounds__(kClusterThreads)
    cluster_kernel(const __grid_constant__ LevelViews<T> views, int first, ResultOutput<T> out) {
  const auto cluster = cooperative_groups::this_cluster();
  const int last = views.count - 1;
  begin_kernel();
  // down: restrict the residual, then solve the level or smooth it
  for (int l = first; l <= last; ++l) {
    const StencilView<T>& v = views.level[l];
    if (l > 0) {
      share_out(v.bricks * stencil::kSlots, [&](int slot) {
        Restriction(v.links, v.row, slot).set(views.level[l - 1].partial, v, slot);
      });
      cluster.sync();
    }
    if (v.inverses != nullptr) {
      share_out(3 * 32 * v.nodes,
                [&](int k) { solve(v, k / 32, l == 0 ? out : ResultOutput<T>{}); });
      cluster.sync();
      continue;
    }
    cluster_pass<T, kAdded>(v, Pass::kStart, {});
    if (l < last) cluster_pass<T, kAdded>(v, Pass::kResidual, {});
  }
  // up: correct by the coarser level and smooth
  for (int l = last; l >= first; --l) {
    const StencilView<T>& v = views.level[l];
    if (v.inverses != nullptr) continue;
    cluster_pass<T, kAdded>(v, Pass::kFirst, {});
    cluster_pass<T, kAdded>(v, Pass::kSecond, l == 0 ? out : ResultOutput<T>{});
  }
}

/// A launch of the cluster kernel by `blocks` blocks.
struct ClusterLaunch {
  ClusterLaunch(unsigned blocks, int shared_bytes, const LaunchOptions& options = {}) {
    attributes[0] = options.attribute();
    attributes[1].id = cudaLaunchAttributeClusterDimension;
    attributes[1].val.clusterDim.x = blocks;
    attributes[1].val.clusterDim.y = attributes[1].val.clusterDim.z = 1;
    config.gridDim = dim3(blocks);
    config.blockDim = dim3(kClusterThreads);
    config.dynamicSmemBytes = size_t(shared_bytes);
    config.stream = options.stream;
    config.attrs = attributes;
    config.numAttrs = 2;
  }
  ClusterLaunch(const ClusterLaunch&) = delete;
  cudaLaunchAttribute attributes[2] = {};
  cudaLaunchConfig_t config{};
};

}  // namespace elastogen::cuda
