// SPDX-License-Identifier: Apache-2.0
#include "network/paper/paper_loop.hpp"
#include "network/paper/paper_operator.hpp"
#include "network/paper/paper_solver.hpp"
#include "network/paper/paper_solver_device.hpp"
#include "network/potential/incremental_potential.cuh"

namespace elastogen::cuda {
namespace {

constexpr int kFields = 15;  // NN and rest of a voxel
constexpr int kBatch = 4;    // modes whose products are summed together

}  // namespace

struct DevicePaper::Impl {
  Impl(DeviceQuasi& q, const PaperLoops& l)
      : quasi(q), loops(l), waves(l.modes / 3), reduced(waves * (waves + 3)) {}
  virtual ~Impl() = default;
  virtual IterationResult solve(const Interrupted& interrupted) = 0;

  DeviceQuasi& quasi;
  PaperLoops loops;
  int waves;
  PinnedArray<double> reduced;  // A_r (waves, waves), then B^T f (waves, 3)
};

namespace {

/// The lagged stress of a voxel, from NN and rest of a table [row][15][lane].
template <bool kAffine, class T>
struct LaggedStress {
  const T* lagged;  ///< of the voxel's row and lane
  T h, omega;

  __device__ void operator()(const T dF[9], T dP[9]) const {
    T NN[6], rest[9];
    for (int k = 0; k < 6; ++k) NN[k] = lagged[k * kLanes];
    for (int k = 0; k < 9; ++k) rest[k] = kAffine ? lagged[(6 + k) * kLanes] : T(0);
    lagged_stress<kAffine>(h, omega, NN, rest, dF, dP);
  }
};

template <class T>
struct Loops : DevicePaper::Impl {
  Loops(DeviceQuasi& q, const PaperLoops& l)
      : Impl(q, l),
        potential(q.potential().impl()),
        lagged(potential.rows.row_count() * kFields * kLanes),
        force(3 * potential.nodes()),
        diagonal(potential.nodes()),
        amplitudes(3 * waves),
        sums(1) {
    const std::vector<double> host = paper_modes(potential.terms.scene(), waves);
    modes = DeviceArray<T>(std::vector<T>(host.begin(), host.end()));
  }

  IterationResult solve(const Interrupted& interrupted) override;
  void begin();
  void freeze();
  template <class Nets>
  void freeze_pass(const Nets& nets);
  void project();
  void sweep();
  void wait() { synchronise(); }

  // parts of these
  template <bool kAffine, class Read, class Finish>
  void apply(const Read& read, const Finish& finish);
  void find_gradient();
  void find_product(int first);
  void reduce(int column, int columns, double* to, int stride);
  void add_modes();

  DevicePotential::Impl& potential;
  DeviceArray<T> lagged, force;
  DeviceArray<T> modes;  // (waves, nodes)
  DeviceArray<double> diagonal, amplitudes;
  DeviceArray<SumScratch<Sums<3 * kBatch>>> sums;
};

/// N and R of every voxel at u, and D.
template <class T>
template <class Nets>
void Loops<T>::freeze_pass(const Nets& nets) {
  const double *u = quasi.u(), *mass = potential.inertia.data();
  double* to_diagonal = diagonal.data();
  T* to = lagged.data();
  const VoxelTables<double> table = potential.template voxels<double>();
  for_each_voxel<double>(
      potential.rows, potential.parts.data(), static_cast<NoSums*>(nullptr),
      [=] __device__(int64_t n, int64_t reference, double v[3]) {
        for (int i = 0; i < 3; ++i) v[i] = u[3 * n + i] - u[3 * reference + i];
      },
      [=] __device__(const VoxelRow& row, int64_t r, int lane, double corner[3][8], double f[3][8],
                     NoSums&) {
        // F of a voxel, the target of its lagged quadratic, and its share in D
        const VoxelData<double> data = table.data(row, r, lane);
        const auto respond = response_of<false>(data.law, nets(row, r, lane));
        for (int i = 0; i < 3; ++i) hex8::to_patterns(corner[i]);
        const Mat3<double> F = deformation_gradient<true>(data, corner);
        const LaggedTarget<double> target = lagged_target(respond, data.law, F);
        T* of = to + r * kFields * kLanes + lane;
        for (int k = 0; k < 6; ++k) of[k * kLanes] = T(target.NN[k]);
        for (int k = 0; k < 9; ++k) of[(6 + k) * kLanes] = T(target.rest[k]);
        diagonal_shares(data, !is_full(data), target.NN, target.largest_slope, f[0]);
      },
      [=] __device__(int64_t n, const NodeSum<double>& given) {
        double sum[3];
        given.get(sum);
        to_diagonal[n] = mass[n] + sum[0];
      });
}

template <class T>
void Loops<T>::freeze() {
  potential.template with_nets<double, NetPass::kStretches>(
      quasi.u(), [&](const auto& nets) { freeze_pass(nets); });
}

/// finish(n, f) with f = sum_v omega G^T (dF N N^T (+ rest)) + variance term on what is read.
template <class T>
template <bool kAffine, class Read, class Finish>
void Loops<T>::apply(const Read& read, const Finish& finish) {
  const VoxelTables<T> table = potential.template voxels<T>();
  const T* from = lagged.data();
  for_each_voxel<T>(
      potential.rows, reinterpret_cast<T*>(potential.parts.data()), static_cast<NoSums*>(nullptr),
      read,
      [=] __device__(const VoxelRow& row, int64_t r, int lane, const T corner[3][8], T f[3][8],
                     NoSums&) {
        const VoxelData<T> data = table.data(row, r, lane);
        const LaggedStress<kAffine, T> stress{from + r * kFields * kLanes + lane, data.h,
                                              lagged_weight(data.law)};
        hessian_product<true>(data, stress, corner, f);
      },
      finish);
}

/// The motion of a node against another one, in T.
template <class T>
struct RelativeMotion {
  const double* u;
  __device__ void operator()(int64_t n, int64_t reference, T v[3]) const {
    for (int i = 0; i < 3; ++i) v[i] = T(u[3 * n + i] - u[3 * reference + i]);
  }
};

/// x += D^-1 (b - A x)
template <class T>
void Loops<T>::sweep() {
  const double *u = quasi.u(), *aim = potential.predictor.data(), *D = diagonal.data(),
               *mass = potential.inertia.data();
  const uint8_t* held = potential.pinned.data();
  double* to = quasi.trial_u();
  apply<true>(RelativeMotion<T>{u}, [=] __device__(int64_t n, const NodeSum<T>& given) {
    T f[3];
    given.get(f);
    for (int i = 0; i < 3; ++i) {
      const int64_t k = 3 * n + i;
      const double gradient = double(f[i]) + mass[n] * (u[k] - aim[k]);
      to[k] = held[n] ? u[k] : u[k] - gradient / D[n];
    }
  });
  quasi.accept_trial();
}

/// force = A u - b
template <class T>
void Loops<T>::find_gradient() {
  const double *u = quasi.u(), *aim = potential.predictor.data(), *mass = potential.inertia.data();
  const uint8_t* held = potential.pinned.data();
  T* to = force.data();
  apply<true>(RelativeMotion<T>{u}, [=] __device__(int64_t n, const NodeSum<T>& given) {
    T f[3];
    given.get(f);
    for (int i = 0; i < 3; ++i) {
      const int64_t k = 3 * n + i;
      to[k] = held[n] ? T(0) : T(double(f[i]) + mass[n] * (u[k] - aim[k]));
    }
  });
}

/// force = A b for three modes from the first on, in place of the three components.
template <class T>
void Loops<T>::find_product(int first) {
  const T* mode = modes.data();
  const int64_t nodes = potential.nodes();
  const int end = waves;
  const double* mass = potential.inertia.data();
  const uint8_t* held = potential.pinned.data();
  T* to = force.data();
  const auto value = [=] __device__(int64_t n, int i) {
    return first + i < end ? mode[(first + i) * nodes + n] : T(0);
  };
  apply<false>(
      [=] __device__(int64_t n, int64_t reference, T v[3]) {
        for (int i = 0; i < 3; ++i) v[i] = value(n, i) - value(reference, i);
      },
      [=] __device__(int64_t n, const NodeSum<T>& given) {
        T f[3];
        given.get(f);
        for (int i = 0; i < 3; ++i)
          to[3 * n + i] = held[n] ? T(0) : f[i] + T(mass[n]) * value(n, i);
      });
}

/// to[k stride + column + i] = mode_k . force_i, the first `columns` components.
template <class T>
void Loops<T>::reduce(int column, int columns, double* to, int stride) {
  using Products = Sums<3 * kBatch>;
  const T *mode = modes.data(), *f = force.data();
  const int64_t nodes = potential.nodes();
  const int end = waves;
  for (int first = 0; first < waves; first += kBatch)
    ordered_sum(
        nodes, sums.data(),
        [=] __device__(int64_t n, Products & sum) {
          for (int j = 0; j < kBatch && first + j < end; ++j)
            for (int i = 0; i < 3; ++i)
              sum.value[3 * j + i] += double(mode[(first + j) * nodes + n]) * double(f[3 * n + i]);
        },
        [=] __device__(const Products& sum) {
          for (int j = 0; j < kBatch && first + j < end; ++j)
            for (int i = 0; i < columns; ++i)
              to[(first + j) * stride + column + i] = sum.value[3 * j + i];
        });
}

/// u -= sum of modes times amplitudes.
template <class T>
void Loops<T>::add_modes() {
  const T* mode = modes.data();
  const double* y = amplitudes.data();
  double* u = quasi.u();
  const int64_t nodes = potential.nodes();
  const int count = waves;
  cuda::for_each(nodes, [=] __device__(int64_t n) {
    double sum[3] = {};
    for (int k = 0; k < count; ++k)
      for (int i = 0; i < 3; ++i) sum[i] += double(mode[k * nodes + n]) * y[3 * k + i];
    for (int i = 0; i < 3; ++i) u[3 * n + i] -= sum[i];
  });
}

/// Galerkin step over the modes.
template <class T>
void Loops<T>::project() {
  double *A = reduced.data(), *y = A + waves * waves;
  find_gradient();
  reduce(0, 3, y, 3);
  for (int first = 0; first < waves; first += 3) {
    find_product(first);
    reduce(first, waves - first < 3 ? waves - first : 3, A, waves);
  }
  synchronise();
  solve_reduced(waves, A, y);
  amplitudes.upload(y);
  add_modes();
}

/// u = xhat - X.
template <class T>
void Loops<T>::begin() {
  check(cudaMemcpyAsync(quasi.u(), potential.predictor.data(),
                        size_t(3 * potential.nodes()) * sizeof(double), cudaMemcpyDeviceToDevice,
                        cudaStreamPerThread));
}

template <class T>
IterationResult Loops<T>::solve(const Interrupted& interrupted) {
  IterationResult result = paper_loop(*this, loops, interrupted);
  result.float64 = sizeof(T) == 8;
  return result;
}

}  // namespace

DevicePaper::DevicePaper(DeviceQuasi& quasi, const PaperLoops& loops, bool float64) {
  check_paper_scene(quasi.potential().terms(), loops);
  if (float64)
    impl_ = std::make_unique<Loops<double>>(quasi, loops);
  else
    impl_ = std::make_unique<Loops<float>>(quasi, loops);
}

DevicePaper::~DevicePaper() = default;

IterationResult DevicePaper::solve(const Interrupted& interrupted) {
  return impl_->solve(interrupted);
}

}  // namespace elastogen::cuda
