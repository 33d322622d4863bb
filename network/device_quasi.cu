// SPDX-License-Identifier: Apache-2.0
#include "core/device_graph.cuh"
#include "core/device_reduce.cuh"
#include "core/line_search.hpp"
#include "network/device_encoder.cuh"
#include "network/device_multigrid.cuh"
#include "network/device_quasi.hpp"

#include <cmath>
#include <limits>
#include <optional>

namespace elastogen::cuda {
namespace {

constexpr int kPatience = 25;  // iterations, as on the CPU
constexpr int kMostHalvings = 12;
constexpr int kPairs = 5;

/// Numbers of an iteration that live on the device.
struct Scalars {
  double alpha[kPairs], rho[kPairs], beta;
  double slope;                        ///< Phi' along the direction, at its start
  double trial_gradient, trial_slope;  ///< |g|^2 and Phi' at the trial, for a whole step
  double sy, ss, yy;                   ///< of the newest pair
};

/// RNN-2's pass on the device (preconditioner.hpp).
struct DevicePreconditioner {
  DevicePreconditioner(DevicePotential& p, const Preconditioner<float>& host)
      : potential(p), multigrid(host.multigrid()), r(3 * p.nodes()), z(3 * p.nodes()) {
    if (host.encoder()) encoder.emplace(*host.encoder());
  }

  template <class T>
  void apply(const T* in, T* out) {
    const float* rotation = potential.nodal_rotation();
    const uint8_t* pinned = potential.pinned();
    float *turned = r.data(), *result = z.data();
    cuda::for_each(potential.nodes(), [=] __device__(int64_t n) {
      const float* R = rotation + 9 * n;
      const T* v = in + 3 * n;
      for (int i = 0; i < 3; ++i)
        turned[3 * n + i] = R[i] * float(v[0]) + R[3 + i] * float(v[1]) + R[6 + i] * float(v[2]);
    });
    graph.run([&] {
      multigrid.apply(turned, result);
      if (encoder) encoder->add(turned, result);
    });
    cuda::for_each(potential.nodes(), [=] __device__(int64_t n) {
      const float* R = rotation + 9 * n;
      const float* w = result + 3 * n;
      for (int i = 0; i < 3; ++i)
        out[3 * n + i] =
            pinned[n] ? T(0) : T(R[3 * i] * w[0] + R[3 * i + 1] * w[1] + R[3 * i + 2] * w[2]);
    });
  }

  DevicePotential& potential;
  DeviceMultigrid<float> multigrid;
  std::optional<DeviceEncoder<float>> encoder;
  DeviceArray<float> r, z;
  DeviceGraph graph;
};

/// The vectors and the history of an iteration in T; lbfgs.hpp on the device.
template <class T>
struct Iteration {
  explicit Iteration(int64_t n)
      : size(n),
        gradient(n),
        trial_gradient(n),
        direction(n),
        work(n),
        scalars(1),
        partial(kSumBlocks) {
    for (int k = 0; k < kPairs; ++k) s.emplace_back(n), y.emplace_back(n);
  }

  size_t pair(int newest) const { return size_t((next - 1 - newest + 2 * kPairs) % kPairs); }

  /// then(sum a_i b_i) on the device.
  template <class Then>
  void dot(const T* a, const T* b, const Then& then) {
    ordered_sum(
        size, partial.data(),
        [=] __device__(int64_t i, Sums<3> & sum) { sum.value[0] += double(a[i]) * double(b[i]); },
        [=] __device__(const Sums<3>& sum) { then(sum.value[0]); });
  }

  void find_direction(DevicePreconditioner& first);
  void measure_trial();
  void take_pair(double* u, const double* trial_u);
  /// Keeps the newest pair if its curvature is safely positive.
  void keep(const Scalars& found) {
    if (!(found.sy > 1e-10 * std::sqrt(found.ss * found.yy)) || found.sy == 0) return;
    next = (next + 1) % kPairs;
    count = std::min(count + 1, kPairs);
  }

  int64_t size;
  DeviceArray<T> gradient, trial_gradient, direction, work;
  std::vector<DeviceArray<T>> s, y;
  DeviceArray<Scalars> scalars;
  DeviceArray<Sums<3>> partial;
  int next = 0, count = 0;
};

/// The two-loop recursion around the preconditioner, and the slope along what it gives.
template <class T>
void Iteration<T>::find_direction(DevicePreconditioner& first) {
  Scalars* scalar = scalars.data();
  T *q = work.data(), *d = direction.data();
  check(cudaMemcpyAsync(q, gradient.data(), size_t(size) * sizeof(T), cudaMemcpyDeviceToDevice));
  for (int k = 0; k < count; ++k) {
    const size_t p = pair(k);
    const T* y_p = y[p].data();
    dot(s[p].data(), q, [=] __device__(double sum) { scalar->alpha[k] = scalar->rho[p] * sum; });
    cuda::for_each(size, [=] __device__(int64_t i) { q[i] -= T(scalar->alpha[k]) * y_p[i]; });
  }
  first.apply(q, d);
  for (int k = count - 1; k >= 0; --k) {
    const size_t p = pair(k);
    const T* s_p = s[p].data();
    dot(y[p].data(), d, [=] __device__(double sum) { scalar->beta = scalar->rho[p] * sum; });
    cuda::for_each(
        size, [=] __device__(int64_t i) { d[i] += T(scalar->alpha[k] - scalar->beta) * s_p[i]; });
  }
  dot(gradient.data(), d, [=] __device__(double sum) { scalar->slope = -sum; });
}

/// |g|^2 of the trial and its slope along the direction.
template <class T>
void Iteration<T>::measure_trial() {
  Scalars* scalar = scalars.data();
  const T *g = trial_gradient.data(), *d = direction.data();
  ordered_sum(
      size, partial.data(),
      [=] __device__(int64_t i, Sums<3> & sum) {
        sum.value[0] += double(g[i]) * double(g[i]);
        sum.value[1] += double(g[i]) * double(d[i]);
      },
      [=] __device__(const Sums<3>& sum) {
        scalar->trial_gradient = sum.value[0];
        scalar->trial_slope = -sum.value[1];
      });
}

/// The pair of an accepted trial, which becomes u.
template <class T>
void Iteration<T>::take_pair(double* u, const double* trial_u) {
  Scalars* scalar = scalars.data();
  const T *g = gradient.data(), *trial_g = trial_gradient.data();
  T *s_n = s[size_t(next)].data(), *y_n = y[size_t(next)].data();
  const int place = next;
  ordered_sum(
      size, partial.data(),
      [=] __device__(int64_t i, Sums<3> & sum) {
        const T step = T(trial_u[i] - u[i]), change = trial_g[i] - g[i];
        s_n[i] = step, y_n[i] = change, u[i] = trial_u[i];
        sum.value[0] += double(step) * double(change);
        sum.value[1] += double(step) * double(step);
        sum.value[2] += double(change) * double(change);
      },
      [=] __device__(const Sums<3>& sum) {
        scalar->sy = sum.value[0], scalar->ss = sum.value[1], scalar->yy = sum.value[2];
        scalar->rho[place] = 1 / sum.value[0];
      });
  std::swap(gradient, trial_gradient);
}

}  // namespace

bool has_device() {
  int count = 0;
  return cudaGetDeviceCount(&count) == cudaSuccess && count > 0;
}

std::string device_name() {
  cudaDeviceProp properties;
  int device = 0;
  check(cudaGetDevice(&device));
  check(cudaGetDeviceProperties(&properties, device));
  return properties.name;
}

struct DeviceQuasi::Impl {
  Impl(const IncrementalPotential& host, const Preconditioner<float>& first_matrix)
      : potential(host),
        first(potential, first_matrix),
        u(3 * potential.nodes()),
        trial_u(u.size()),
        gradient(u.size()),
        square_sums(kSumBlocks),
        square(1) {}

  template <class T>
  Iteration<T>& iteration();
  template <class T>
  IterationResult solve(double target, int max_outer, const std::function<bool()>& interrupted);
  template <class T>
  bool line_search(Iteration<T>& it, PotentialValue& value, int& evaluations, Scalars& found);
  template <class T>
  void move(const Iteration<T>& it, double a);

  DevicePotential potential;
  DevicePreconditioner first;
  DeviceArray<double> u, trial_u;
  DeviceArray<double> gradient;  // of the certificate
  DeviceArray<Sums<1>> square_sums;
  DeviceArray<double> square;
  std::optional<Iteration<float>> single;
  std::optional<Iteration<double>> precise;
};

template <class T>
Iteration<T>& DeviceQuasi::Impl::iteration() {
  if constexpr (sizeof(T) == 4) {
    if (!single) single.emplace(u.size());
    return *single;
  } else {
    if (!precise) precise.emplace(u.size());
    return *precise;
  }
}

/// trial_u = u - a d.
template <class T>
void DeviceQuasi::Impl::move(const Iteration<T>& it, double a) {
  const double* from = u.data();
  const T* d = it.direction.data();
  double* to = trial_u.data();
  cuda::for_each(u.size(), [=] __device__(int64_t i) { to[i] = from[i] - a * double(d[i]); });
}

/// Halves the step until Phi falls.
template <class T>
bool DeviceQuasi::Impl::line_search(Iteration<T>& it, PotentialValue& value, int& evaluations,
                                    Scalars& found) {
  const double noise = potential.host().noise(value, std::numeric_limits<T>::epsilon());
  double a = 1;
  for (int halvings = 0; halvings <= kMostHalvings; ++halvings, a /= 2) {
    move(it, a);
    const PotentialValue trial = potential.evaluate<T>(trial_u.data(), it.trial_gradient.data());
    ++evaluations;
    it.measure_trial();
    it.scalars.download(&found);
    if (!(found.slope < 0)) return false;
    const double difference = trial.total() - value.total(), slope = a * found.trial_slope;
    if (std::isfinite(difference) && std::isfinite(slope) &&
        sufficient_decrease(difference, a * found.slope, slope, noise)) {
      value = trial;
      return true;
    }
  }
  return false;
}

template <class T>
IterationResult DeviceQuasi::Impl::solve(double target, int max_outer,
                                         const std::function<bool()>& interrupted) {
  Iteration<T>& it = iteration<T>();
  it.next = it.count = 0;
  IterationResult result;
  PotentialValue value = potential.evaluate<T>(u.data(), it.gradient.data());
  result.inner = 1;
  std::swap(it.gradient, it.trial_gradient);
  it.measure_trial();
  std::swap(it.gradient, it.trial_gradient);
  Scalars found;
  it.scalars.download(&found);
  double residual = std::sqrt(found.trial_gradient), half = 1e300;
  int halved_at = 0;
  while (true) {
    if (residual < half) half = residual / 2, halved_at = result.outer;
    const bool stalled = sizeof(T) == 4 && result.outer - halved_at > kPatience;
    result.converged = residual <= target;
    if (result.converged || stalled || result.outer == max_outer || interrupted()) return result;
    it.find_direction(first);
    if (!line_search(it, value, result.inner, found)) {
      if (it.count == 0) return result;
      it.next = it.count = 0;
      continue;
    }
    residual = std::sqrt(found.trial_gradient);
    it.take_pair(u.data(), trial_u.data());
    it.scalars.download(&found);
    it.keep(found);
    ++result.outer;
  }
}

DeviceQuasi::DeviceQuasi(const IncrementalPotential& potential, const Preconditioner<float>& first)
    : impl_(std::make_unique<Impl>(potential, first)) {}

DeviceQuasi::~DeviceQuasi() = default;

void DeviceQuasi::begin_step() {
  impl_->potential.begin_step();
}

void DeviceQuasi::set_nodal_rotations(const double* u) {
  impl_->u.upload(u);
  impl_->potential.set_nodal_rotations(impl_->u.data());
}

PotentialValue DeviceQuasi::value(const double* u) {
  impl_->u.upload(u);
  // its gradient is of no use, that of the certificate stays
  return impl_->potential.evaluate<double>(impl_->u.data(), impl_->trial_u.data());
}

PotentialValue DeviceQuasi::residual(const double* u, double& size) {
  Impl& s = *impl_;
  s.u.upload(u);
  const PotentialValue result = s.potential.residual(s.u.data(), s.gradient.data());
  const double* g = s.gradient.data();
  double* square = s.square.data();
  ordered_sum(
      s.gradient.size(), s.square_sums.data(),
      [=] __device__(int64_t i, Sums<1> & sum) { sum.value[0] += g[i] * g[i]; },
      [=] __device__(const Sums<1>& sum) { *square = sum.value[0]; });
  s.square.download(&size);
  size = std::sqrt(size);
  return result;
}

void DeviceQuasi::download_gradient(double* gradient) const {
  impl_->gradient.download(gradient);
}

IterationResult DeviceQuasi::solve(double* u, double target, int max_outer, bool float64,
                                   const std::function<bool()>& interrupted) {
  impl_->u.upload(u);
  const IterationResult result = float64 ? impl_->solve<double>(target, max_outer, interrupted)
                                         : impl_->solve<float>(target, max_outer, interrupted);
  impl_->u.download(u);
  return result;
}

DevicePotential& DeviceQuasi::potential() {
  return impl_->potential;
}

template <class T>
void DeviceQuasi::precondition(const T* r, T* z) {
  impl_->first.apply(r, z);
}

template void DeviceQuasi::precondition(const float*, float*);
template void DeviceQuasi::precondition(const double*, double*);

std::unique_ptr<DeviceIterations> make_device_iterations(const IncrementalPotential& potential,
                                                         const Preconditioner<float>& first) {
  return std::make_unique<DeviceQuasi>(potential, first);
}

}  // namespace elastogen::cuda
