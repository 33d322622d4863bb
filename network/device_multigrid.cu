// SPDX-License-Identifier: Apache-2.0
#include "core/device_array.cuh"
#include "network/device_multigrid.cuh"
#include "network/device_stencil_pass.cuh"
#include "network/multigrid_element.hpp"

#include <cooperative_groups.h>

namespace elastogen::cuda {
namespace {

constexpr int kMaxLevels = 12;
// nodes a thread, 512 / kRun threads a brick: long runs cost least where bricks fill the card,
// short ones end sooner
constexpr int kLongRun = 4, kShortRun = 2, kClusterRun = 1;
constexpr int kShortBricks = 512;   // of levels with short runs
constexpr int kClusterBricks = 32;  // of levels that a cluster of blocks works on
constexpr int kClusterThreads = stencil::kSlots / kClusterRun;

template <class T>
struct Level {
  Level(const MultigridLevel<T>& host, const StencilBricks<T>& g)
      : links(g.links),
        begin(g.begin),
        slot(g.slot),
        row(g.row),
        rows(g.rows),
        inverses(host.inverses),
        r(g.brick_count() * stencil::kBrick),
        z((g.brick_count() + 1) * stencil::kBrick),
        other(z.size()),
        partial((g.brick_count() + 1) * 3 * stencil::kPartial),
        smoother(host.lambda_max) {}

  StencilView<T> view() {
    return {links.data(),
            begin.data(),
            slot.data(),
            row.data(),
            rows.data(),
            inverses.data(),
            r.data(),
            z.data(),
            other.data(),
            partial.data(),
            int32_t(links.size()),
            int32_t(slot.size()),
            T(smoother.first),
            T(smoother.keep),
            T(smoother.add)};
  }

  DeviceArray<BrickLinks> links;
  DeviceArray<int32_t> begin, slot, row;
  DeviceArray<T> rows, inverses;
  DeviceArray<T> r, z, other, partial;
  Chebyshev smoother;
};

/// The levels, 0 the finest, as a kernel takes them.
template <class T>
struct Views {
  StencilView<T> level[kMaxLevels];
  int count;
};

template <class T, int kRun>
__global__ void __launch_bounds__(stencil::kSlots / kRun, sizeof(T) == 4 ? 2 * kRun : 1)
    pass_kernel(const __grid_constant__ StencilView<T> v, Pass pass, T* out) {
  extern __shared__ __align__(16) unsigned char room[];
  stencil::run_pass<T, kRun>(v, pass, blockIdx.x, reinterpret_cast<T*>(room), out);
}

/// body(k) for each k of [0, n) by the threads of the grid.
template <class Body>
__device__ void share(int n, const Body& body) {
  for (int k = int(blockIdx.x * blockDim.x + threadIdx.x); k < n; k += int(gridDim.x * blockDim.x))
    body(k);
}

template <class T>
__device__ void cluster_pass(const StencilView<T>& v, Pass pass, T* out) {
  extern __shared__ __align__(16) unsigned char room[];
  for (int32_t brick = int32_t(blockIdx.x); brick < v.bricks; brick += int32_t(gridDim.x)) {
    stencil::run_pass<T, kClusterRun>(v, pass, brick, reinterpret_cast<T*>(room), out);
    __syncthreads();
  }
  cooperative_groups::this_cluster().sync();
}

/// The levels from `first` on as one cluster of blocks, which waits between passes within the card:
/// down to the coarsest and back. `out` is z of level 0 by node, nullptr where first > 0.
template <class T>
__global__ void __launch_bounds__(kClusterThreads)
    cluster_kernel(const __grid_constant__ Views<T> views, int first, T* out) {
  const auto cluster = cooperative_groups::this_cluster();
  const int last = views.count - 1;
  for (int l = first; l <= last; ++l) {
    const StencilView<T>& v = views.level[l];
    if (l > 0) {
      share(v.bricks * stencil::kSlots,
            [&](int slot) { restrict_residual(views.level[l - 1], v, slot); });
      cluster.sync();
    }
    if (v.inverses != nullptr) {
      share(3 * 32 * v.nodes, [&](int k) { solve(v, k / 32, l == 0 ? out : nullptr); });
      cluster.sync();
      continue;
    }
    cluster_pass<T>(v, Pass::kStart, nullptr);
    if (l < last) cluster_pass<T>(v, Pass::kResidual, nullptr);
  }
  for (int l = last; l >= first; --l) {
    const StencilView<T>& v = views.level[l];
    if (v.inverses != nullptr) continue;
    if (l < last) {
      share(v.bricks * stencil::kSlots,
            [&](int slot) { prolong_correction(v, views.level[l + 1], slot); });
      cluster.sync();
    }
    cluster_pass<T>(v, Pass::kFirst, nullptr);
    cluster_pass<T>(v, Pass::kSecond, l == 0 ? out : nullptr);
  }
}

/// A launch of the cluster kernel by `blocks` blocks.
struct ClusterLaunch {
  ClusterLaunch(unsigned blocks, int shared_bytes) {
    attribute.id = cudaLaunchAttributeClusterDimension;
    attribute.val.clusterDim.x = blocks;
    attribute.val.clusterDim.y = attribute.val.clusterDim.z = 1;
    config.gridDim = dim3(blocks);
    config.blockDim = dim3(kClusterThreads);
    config.dynamicSmemBytes = size_t(shared_bytes);
    config.stream = cudaStreamPerThread;
    config.attrs = &attribute;
    config.numAttrs = 1;
  }
  ClusterLaunch(const ClusterLaunch&) = delete;
  cudaLaunchAttribute attribute{};
  cudaLaunchConfig_t config{};
};

}  // namespace

template <class T>
struct DeviceMultigridLevels {
  explicit DeviceMultigridLevels(const Multigrid<T>& host) : scale(T(1 / host.level(0).unit)) {
    add_levels(host);
    views.count = first_in_cluster = int(levels.size());
    for (int l = 0; l < views.count; ++l) views.level[l] = levels[size_t(l)]->view();
    while (first_in_cluster > 0 && fits_cluster(views.level[first_in_cluster - 1]))
      --first_in_cluster;
    prepare_kernels();
  }

  static bool fits_cluster(const StencilView<T>& v) {
    return v.inverses != nullptr || v.bricks <= kClusterBricks;
  }

  void add_levels(const Multigrid<T>& host) {
    ELASTOGEN_CHECK(host.level_count() <= kMaxLevels, "at most ", kMaxLevels, " levels");
    StencilBricks<T> finer = make_stencil_bricks(host.level(0));
    for (int l = 1; l < host.level_count(); ++l) {
      StencilBricks<T> coarser = make_stencil_bricks(host.level(l));
      link_levels(finer, coarser);
      levels.push_back(std::make_unique<Level<T>>(host.level(l - 1), finer));
      finer = std::move(coarser);
    }
    levels.push_back(std::make_unique<Level<T>>(host.level(host.level_count() - 1), finer));
  }

  /// Asks for shared memory, and for 16 blocks of a cluster where the card has room for them.
  void prepare_kernels() {
    constexpr int kBytes = stencil::kSharedBytes<T>;
    constexpr auto kShared = cudaFuncAttributeMaxDynamicSharedMemorySize;
    check(cudaFuncSetAttribute(pass_kernel<T, kLongRun>, kShared, kBytes));
    check(cudaFuncSetAttribute(pass_kernel<T, kShortRun>, kShared, kBytes));
    check(cudaFuncSetAttribute(cluster_kernel<T>, kShared, kBytes));
    check(
        cudaFuncSetAttribute(cluster_kernel<T>, cudaFuncAttributeNonPortableClusterSizeAllowed, 1));
    int clusters = 0;
    const ClusterLaunch launch(cluster_blocks, kBytes);
    const cudaError_t asked =
        cudaOccupancyMaxActiveClusters(&clusters, cluster_kernel<T>, &launch.config);
    if (asked == cudaSuccess && clusters > 0) return;
    cudaGetLastError();  // cleared, so that no later call reports it
    cluster_blocks = 8;  // which every card grants
  }

  void run(int l, Pass pass, T* out = nullptr) {
    const StencilView<T>& v = views.level[l];
    const bool is_short = v.bricks <= kShortBricks;
    const auto kernel = is_short ? pass_kernel<T, kShortRun> : pass_kernel<T, kLongRun>;
    const int threads = stencil::kSlots / (is_short ? kShortRun : kLongRun);
    // only the last pass needs room for z
    const int bytes =
        stencil::kSharedBytes<T> - (pass == Pass::kSecond ? 0 : stencil::kBrick * int(sizeof(T)));
    kernel<<<unsigned(v.bricks), unsigned(threads), bytes>>>(v, pass, out);
    check(cudaGetLastError());
  }

  void run_cluster(T* out) {
    const ClusterLaunch launch(cluster_blocks, stencil::kSharedBytes<T>);
    check(cudaLaunchKernelEx(&launch.config, cluster_kernel<T>, views, first_in_cluster, out));
  }

  /// The cycle from level l on; level 0 has its residual.
  void cycle(int l, T* out) {
    if (l == first_in_cluster) return run_cluster(out);
    const StencilView<T> v = views.level[l];
    const int64_t slots = int64_t(v.bricks) * stencil::kSlots;
    if (l > 0) {
      const StencilView<T> finer = views.level[l - 1];
      cuda::for_each(slots, [=] __device__(int64_t s) { restrict_residual(finer, v, int(s)); });
    }
    run(l, Pass::kStart);
    if (l + 1 < views.count) {
      run(l, Pass::kResidual);
      cycle(l + 1, nullptr);
      const StencilView<T> coarser = views.level[l + 1];
      cuda::for_each(slots, [=] __device__(int64_t s) { prolong_correction(v, coarser, int(s)); });
    }
    run(l, Pass::kFirst);
    run(l, Pass::kSecond, out);
  }

  std::vector<std::unique_ptr<Level<T>>> levels;
  Views<T> views;
  int first_in_cluster;
  unsigned cluster_blocks = 16;
  T scale;  // 1 / unit
};

template <class T>
DeviceMultigrid<T>::DeviceMultigrid(const Multigrid<T>& host)
    : levels_(std::make_unique<DeviceMultigridLevels<T>>(host)) {}

template <class T>
DeviceMultigrid<T>::~DeviceMultigrid() = default;

template <class T>
void DeviceMultigrid<T>::apply(const T* r, T* z) {
  const StencilView<T> v = levels_->views.level[0];
  const T scale = levels_->scale;
  cuda::for_each(int64_t(v.nodes), [=] __device__(int64_t n) {
    const T value[3] = {scale * r[3 * n], scale * r[3 * n + 1], scale * r[3 * n + 2]};
    set_residual(v, v.slot[n], value);
  });
  levels_->cycle(0, z);
}

template class DeviceMultigrid<float>;
template class DeviceMultigrid<double>;

}  // namespace elastogen::cuda
