// SPDX-License-Identifier: Apache-2.0
#include "network/precondition/dense.cuh"
#include "network/precondition/multigrid.cuh"
#include "network/precondition/multigrid_grid.cuh"
#include "network/precondition/stencil_pass.cuh"
#include "network/precondition/stencil_stiffness.cuh"

#include <cooperative_groups.h>

namespace elastogen::cuda {
namespace {

// nodes of a thread; a brick has 512 / kRun threads: long runs cost least where bricks fill the
// card, short ones end sooner
constexpr int kLongRun = 4, kShortRun = 2, kSingleRun = 1;
constexpr int kShortBricks = 512;   // of levels with short runs
constexpr int kSingleBricks = 128;  // of levels with one node a thread
constexpr int kClusterBricks = 16;  // of levels in the cluster, one for each block
constexpr int kClusterThreads = stencil::kSlots / kSingleRun;
constexpr int kRestrictThreads = 256;

template <class T>
struct Level {
  explicit Level(HierarchyLevel<T>&& made)
      : of(std::move(made)),
        r(of.links.size() * stencil::kBrick),
        z((of.links.size() + 1) * stencil::kBrick),
        other(z.size()),
        partial((of.links.size() + 1) * 3 * stencil::kPartial),
        smoother(of.lambda_max) {}
  StencilView<T> view() {
    StencilView<T> result{of.links.data(),
                          of.begin.data(),
                          of.slot.data(),
                          of.row.data(),
                          of.rows.data(),
                          inverses.data(),
                          r.data(),
                          z.data(),
                          other.data(),
                          partial.data(),
                          int32_t(of.links.size()),
                          int32_t(of.slot.size()),
                          T(smoother.first),
                          T(smoother.keep),
                          T(smoother.add)};
    result.pitch = int32_t(dense_pitch(of.slot.size()));
    return result;
  }
  HierarchyLevel<T> of;
  DeviceArray<T> inverses;  // of the coarsest one, where it is solved
  DeviceArray<T> r, z, other, partial;
  Chebyshev smoother;
  // for an additional stiffness, after expect_stiffness()
  DeviceArray<T> added, added_inverses;
  DeviceArray<int32_t> stiff;
};

/// The levels for a kernel, 0 the finest.
template <class T>
struct Views {
  StencilView<T> level[kMostLevels];
  int count;
};

// a pass over a level (device_stencil_pass.cuh), one block for each brick
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

// r of a level from the partial sums of the finer one, one thread for each slot
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
__device__ void share(int n, const Body& body) {
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
    cluster_kernel(const __grid_constant__ Views<T> views, int first, ResultOutput<T> out) {
  const auto cluster = cooperative_groups::this_cluster();
  const int last = views.count - 1;
  begin_kernel();
  // down: restrict the residual, then solve the level or smooth it
  for (int l = first; l <= last; ++l) {
    const StencilView<T>& v = views.level[l];
    if (l > 0) {
      share(v.bricks * stencil::kSlots, [&](int slot) {
        Restriction(v.links, v.row, slot).set(views.level[l - 1].partial, v, slot);
      });
      cluster.sync();
    }
    if (v.inverses != nullptr) {
      share(3 * 32 * v.nodes, [&](int k) { solve(v, k / 32, l == 0 ? out : ResultOutput<T>{}); });
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

}  // namespace

template <class T>
struct DeviceMultigridLevels {
  /// @param fixed  the operators of the last level never change: the whole card may solve it.
  DeviceMultigridLevels(Hierarchy<T>&& made, bool fixed) : unit(made.unit), scale(T(1 / unit)) {
    for (HierarchyLevel<T>& level : made.levels)
      levels.push_back(std::make_unique<Level<T>>(std::move(level)));
    take_operators(std::move(made.operators), fixed);
    views.count = first_in_cluster = int(levels.size());
    for (int l = 0; l < views.count; ++l) views.level[l] = levels[size_t(l)]->view();
    for (int l = 0; l + 1 < views.count; ++l) views.level[l].coarse_z = views.level[l + 1].z;
    while (!solved.exists() && first_in_cluster > 0 &&
           fits_cluster(views.level[first_in_cluster - 1]))
      --first_in_cluster;
    prepare_kernels<false>();
  }

  void take_operators(DeviceArray<double>&& made, bool fixed) {
    if (made.size() == 0) return;
    Level<T>& last = *levels.back();
    if (fixed) {
      solved = DenseSolve<T>(std::move(made), last.of.slot.size());
      return;
    }
    operators = DeviceArray<double>(made.size());
    if (operators.data() != nullptr)
      check(cudaMemcpyAsync(operators.data(), made.data(), size_t(made.size()) * sizeof(double),
                            cudaMemcpyDeviceToDevice, cudaStreamPerThread));
    last.inverses = dense_inverses<T>(std::move(made), last.of.slot.size());
  }

  static bool fits_cluster(const StencilView<T>& v) {
    return v.inverses != nullptr || v.bricks <= kClusterBricks;
  }

  /// Asks for shared memory, and for 16 blocks in a cluster if the card can run that many.
  template <bool kAdded>
  void prepare_kernels() {
    constexpr int kBytes = stencil::kSharedBytes<T>;
    constexpr auto kShared = cudaFuncAttributeMaxDynamicSharedMemorySize;
    const auto cluster = cluster_kernel<T, kAdded>;
    check(cudaFuncSetAttribute(pass_kernel<T, kLongRun, kAdded>, kShared, kBytes));
    check(cudaFuncSetAttribute(pass_kernel<T, kShortRun, kAdded>, kShared, kBytes));
    check(cudaFuncSetAttribute(pass_kernel<T, kSingleRun, kAdded>, kShared, kBytes));
    check(cudaFuncSetAttribute(cluster, kShared, kBytes));
    check(cudaFuncSetAttribute(cluster, cudaFuncAttributeNonPortableClusterSizeAllowed, 1));
    int clusters = 0;
    const ClusterLaunch launch(cluster_blocks, kBytes);
    const cudaError_t asked = cudaOccupancyMaxActiveClusters(&clusters, cluster, &launch.config);
    if (asked == cudaSuccess && clusters > 0) return;
    cudaGetLastError();  // cleared, so that no later call reports it
    cluster_blocks = 8;  // which every card grants
  }

  void expect_stiffness();
  void set_nodal_stiffness(const NodalStiffness& stiffness);
  const Views<T>& present() const { return use_stiffness ? stiff_views : views; }

  /// The kernel for a level, and how many nodes its threads have.
  template <bool kAdded>
  static std::pair<decltype(&pass_kernel<T, kLongRun, kAdded>), int> kernel_for(int32_t bricks) {
    if (bricks <= kSingleBricks) return {pass_kernel<T, kSingleRun, kAdded>, kSingleRun};
    if (bricks <= kShortBricks) return {pass_kernel<T, kShortRun, kAdded>, kShortRun};
    return {pass_kernel<T, kLongRun, kAdded>, kLongRun};
  }

  void run(int l, Pass pass, const ResultOutput<T>& out = {}, bool early = true) {
    const StencilView<T>& v = present().level[l];
    const bool last = l + 1 == views.count;
    const auto [kernel, nodes] =
        use_stiffness ? kernel_for<true>(v.bricks) : kernel_for<false>(v.bricks);
    const int threads = stencil::kSlots / nodes;
    // only the last pass keeps z in shared memory, only passes that prolong keep coarse values
    int bytes = stencil::kSharedBytes<T>;
    if (pass != Pass::kSecond) bytes -= stencil::kBrick * int(sizeof(T));
    if (last || pass == Pass::kStart || pass == Pass::kResidual)
      bytes -= stencil::kCoarse * int(sizeof(T));
    const bool to_finer = l > 0 && pass == Pass::kSecond;
    const bool late = to_finer && present().level[l - 1].bricks <= kFewBlocks;
    launch_on({.early = early}, kernel, unsigned(v.bricks), unsigned(threads), size_t(bytes), v,
              pass, out, late);
  }

  void run_cluster(const ResultOutput<T>& out, bool early) {
    const ClusterLaunch launch(cluster_blocks, stencil::kSharedBytes<T>, {.early = early});
    const auto kernel = use_stiffness ? cluster_kernel<T, true> : cluster_kernel<T, false>;
    check(cudaLaunchKernelEx(&launch.config, kernel, present(), first_in_cluster, out));
  }

  /// Solves the last level by the whole card.
  void solve_last(const ResultOutput<T>& out, bool early) {
    const int l = views.count - 1;
    const T* const partial = l > 0 ? present().level[l - 1].partial : nullptr;
    solved.run(present().level[l], partial, l == 0 ? out : ResultOutput<T>{}, {.early = early});
  }

  /// The first pass over the finest level, whose residual is set.
  void start() {
    const bool passes = first_in_cluster > 0 && !(views.count == 1 && solved.exists());
    if (passes) run(0, Pass::kStart);
  }

  /// The cycle from level l on; on the finest level it comes after start().
  void cycle(int l, const ResultOutput<T>& out, const Companion<T>& beside) {
    const bool last = l + 1 == views.count;
    const bool alone = !beside.begin;
    if (!alone && (last || l == first_in_cluster)) beside.begin(), beside.end();
    if (l == first_in_cluster) return run_cluster(out, alone);
    if (last && solved.exists()) return solve_last(out, alone);
    if (l > 0) {
      const StencilView<T>& v = present().level[l];
      launch(restrict_kernel<T>, unsigned(v.bricks * stencil::kSlots / kRestrictThreads),
             kRestrictThreads, 0, present().level[l - 1].partial, v);
      run(l, Pass::kStart);
    }
    if (!last) {
      run(l, Pass::kResidual);
      if (!alone) beside.begin();
      cycle(l + 1, {}, {});
      if (!alone) beside.end();
    }
    run(l, Pass::kFirst, {}, alone);
    run(l, Pass::kSecond, out);
  }

  std::vector<std::unique_ptr<Level<T>>> levels;
  Views<T> views;
  int first_in_cluster;
  unsigned cluster_blocks = 16;
  double unit;                    // [N/m]
  T scale;                        // 1 / unit
  DenseSolve<T> solved;           // the last level, if the whole card solves it
  DeviceArray<double> operators;  // those of a last level that the cluster solves
  // for an additional stiffness, after expect_stiffness()
  Views<T> stiff_views;
  bool use_stiffness = false;
};

template <class T>
void DeviceMultigridLevels<T>::expect_stiffness() {
  stiff_views = views;
  for (int l = 0; l < views.count; ++l) {
    Level<T>& level = *levels[size_t(l)];
    level.added = DeviceArray<T>(level.z.size());
    level.stiff = DeviceArray<int32_t>(level.of.links.size() + 1);
    level.added_inverses = DeviceArray<T>(level.inverses.size());
    StencilView<T>& view = stiff_views.level[l];
    view.added = level.added.data();
    view.stiff = level.stiff.data();
    view.inverses = level.added_inverses.data();
  }
  ELASTOGEN_CHECK(!solved.exists(), "the level that is solved must not change");
  ELASTOGEN_CHECK(operators.size() == 0 || views.level[views.count - 1].nodes <= StiffTile::kRows,
                  "at most ", StiffTile::kRows, " nodes of a level that is solved");
  prepare_kernels<true>();
}

/// Sets the added stiffness of all levels, and the inverses of a level that is solved.
template <class T>
void DeviceMultigridLevels<T>::set_nodal_stiffness(const NodalStiffness& stiffness) {
  const StencilView<T> v = stiff_views.level[0];
  const double of = unit;
  check(cudaMemsetAsync(v.stiff, 0, size_t(v.bricks) * sizeof(int32_t), cudaStreamPerThread));
  // the finest level by slot
  cuda::for_each(stiffness.count, [=] __device__(int64_t s) {
    const int slot = v.slot[stiffness.nodes[s]];
    bool any = false;
    for (int i = 0; i < 3; ++i) {
      const double value = stiffness.blocks[6 * s + symmetric_place(i, i)];
      v.added[3 * int64_t(slot) + i] = T(value / of);
      any |= value != 0;
    }
    if (any) v.stiff[slot / stencil::kSlots] = 1;
  });
  // coarser levels from finer ones
  for (int l = 1; l < views.count; ++l) {
    const StencilView<T>& coarse = stiff_views.level[l];
    stiffness_kernel<<<unsigned(coarse.bricks), stencil::kSlots>>>(stiff_views.level[l - 1],
                                                                   coarse);
    check(cudaGetLastError());
  }
  const StencilView<T>& last = stiff_views.level[views.count - 1];
  if (operators.size() == 0) return;
  const auto kernel = last.nodes <= SmallStiffTile::kRows ? inverse_kernel<T, SmallStiffTile>
                                                          : inverse_kernel<T, StiffTile>;
  constexpr dim3 kThreads(StiffTile::kWidth, StiffTile::kWidth);
  kernel<<<3, kThreads>>>(last, operators.data(), levels.back()->added_inverses.data());
  check(cudaGetLastError());
}

template <class T>
DeviceMultigrid<T>::DeviceMultigrid(DevicePotential& potential)
    : levels_(std::make_unique<DeviceMultigridLevels<T>>(
          make_hierarchy<T>(potential), potential.terms().scene().colliders.empty())) {}

template <class T>
DeviceMultigrid<T>::~DeviceMultigrid() = default;

template <class T>
ResidualInput<T> DeviceMultigrid<T>::input() const {
  return {levels_->present().level[0], levels_->scale};
}

template <class T>
void DeviceMultigrid<T>::expect_stiffness() {
  levels_->expect_stiffness();
}

template <class T>
void DeviceMultigrid<T>::set_nodal_stiffness(const NodalStiffness& stiffness) {
  levels_->set_nodal_stiffness(stiffness);
}

template <class T>
void DeviceMultigrid<T>::use_stiffness(bool use) {
  levels_->use_stiffness = use;
}

template <class T>
void DeviceMultigrid<T>::start() {
  levels_->start();
}

template <class T>
void DeviceMultigrid<T>::cycle(T* z, const Companion<T>& companion) {
  levels_->cycle(0, {z, companion.result}, companion);
}

template <class T>
void DeviceMultigrid<T>::apply(const T* r, T* z) {
  const ResidualInput<T> to = input();
  cuda::for_each(int64_t(to.finest.nodes), [=] __device__(int64_t n) { to.set(n, r + 3 * n); });
  start();
  cycle(z);
}

template class DeviceMultigrid<float>;
template class DeviceMultigrid<double>;

}  // namespace elastogen::cuda
