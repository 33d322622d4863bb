// SPDX-License-Identifier: Apache-2.0
#include "network/precondition/dense.cuh"
#include "network/precondition/multigrid.cuh"
#include "network/precondition/multigrid_grid.cuh"
#include "network/precondition/multigrid_kernels.cuh"
#include "network/precondition/stencil_stiffness.cuh"

namespace elastogen::cuda {
namespace {

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

  void expect_stiffness(const double* mass);
  void set_nodal_stiffness(const NodalStiffness& stiffness);
  void set_finest_stiffness(const NodalStiffness& stiffness);
  const LevelViews<T>& present() const { return use_stiffness ? stiff_views : views; }

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
  LevelViews<T> views;
  int first_in_cluster;
  unsigned cluster_blocks = 16;
  double unit;                    // [N/m]
  T scale;                        // 1 / unit
  DenseSolve<T> solved;           // the last level, if the whole card solves it
  DeviceArray<double> operators;  // those of a last level that the cluster solves
  // for an additional stiffness, after expect_stiffness()
  LevelViews<T> stiff_views;
  bool use_stiffness = false;
  const double* masses = nullptr;  // of the nodes, where steps may have other lengths
  DeviceArray<double> more;        // inertia over mass, beyond that of the operators [1/s^2]
};

template <class T>
void DeviceMultigridLevels<T>::expect_stiffness(const double* mass) {
  stiff_views = views;
  masses = mass;
  more = DeviceArray<double>(1);
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

/// Sets the added stiffness of the finest level by slot: other inertia, then stiffness of nodes.
template <class T>
void DeviceMultigridLevels<T>::set_finest_stiffness(const NodalStiffness& stiffness) {
  const StencilView<T> v = stiff_views.level[0];
  const double of = unit, *const mass = masses, *const beyond = more.data();
  check(cudaMemsetAsync(v.stiff, 0, size_t(v.bricks) * sizeof(int32_t), cudaStreamPerThread));
  if (mass != nullptr)
    cuda::for_each(v.nodes, [=] __device__(int64_t n) {
      const int slot = v.slot[n];
      const double value = v.row[slot] == 0 ? 0 : *beyond * mass[n];
      for (int i = 0; i < 3; ++i) v.added[3 * int64_t(slot) + i] = T(value / of);
      if (value != 0) v.stiff[slot / stencil::kSlots] = 1;
    });
  cuda::for_each(stiffness.count, [=] __device__(int64_t s) {
    const int slot = v.slot[stiffness.nodes[s]];
    bool any = false;
    for (int i = 0; i < 3; ++i) {
      const double value = stiffness.blocks[6 * s + symmetric_place(i, i)];
      T& added = v.added[3 * int64_t(slot) + i];
      added = T((mass != nullptr ? double(added) : 0) + value / of);
      any |= value != 0;
    }
    if (any) v.stiff[slot / stencil::kSlots] = 1;
  });
}

/// Sets the added stiffness of all levels, and the inverses of a level that is solved.
template <class T>
void DeviceMultigridLevels<T>::set_nodal_stiffness(const NodalStiffness& stiffness) {
  set_finest_stiffness(stiffness);
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
          make_hierarchy<T>(potential), !operators_change(potential.terms().scene()))) {}

template <class T>
DeviceMultigrid<T>::~DeviceMultigrid() = default;

template <class T>
ResidualInput<T> DeviceMultigrid<T>::input() const {
  return {levels_->present().level[0], levels_->scale};
}

template <class T>
void DeviceMultigrid<T>::expect_stiffness(const double* mass) {
  levels_->expect_stiffness(mass);
}

template <class T>
void DeviceMultigrid<T>::add_inertia(double more) {
  levels_->more.upload(&more);
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
