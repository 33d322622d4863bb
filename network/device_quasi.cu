// SPDX-License-Identifier: Apache-2.0
#include "core/device_reduce.cuh"
#include "core/line_search.hpp"
#include "network/device_preconditioner.cuh"
#include "network/device_quasi.hpp"
#include "network/lbfgs_products.hpp"

#include <cmath>
#include <limits>
#include <optional>

namespace elastogen::cuda {
namespace {

constexpr int kPatience = 25;  // iterations, as on the CPU
constexpr int kMostHalvings = 12;
constexpr int kPairs = LbfgsProducts::kPairs, kOlder = LbfgsProducts::kOlder;
constexpr int kTrialSums = 7 + 2 * kOlder;

/// What an iteration tells the host.
struct Numbers {
  double slope;                  ///< Phi' along the direction, at its start
  double gradient, trial_slope;  ///< |g|^2 and Phi' at the trial, for a whole step
  LbfgsProducts::Newest pair;
};

/// The vectors of the pairs, the newest first.
template <class T>
struct PairVectors {
  const T *s[kPairs], *y[kPairs];
  int count;
};

struct FirstLoop {
  double alpha[kPairs];
};

/// The vectors and the history of an iteration in T; lbfgs.hpp on the device.
template <class T>
struct Iteration {
  explicit Iteration(int64_t n)
      : size(n),
        gradient(n),
        trial_gradient(n),
        direction(n),
        coefficients(kPairs),
        pair_sums(1),
        slope_sums(1),
        trial_sums(1),
        numbers(1) {
    for (int k = 0; k < kPairs; ++k) s.emplace_back(n), y.emplace_back(n);
  }

  void clear() { products.count = 0; }
  int slot(int newest) const { return (next - 1 - newest + 2 * kPairs) % kPairs; }
  PairVectors<T> pairs() const {
    PairVectors<T> list{{}, {}, products.count};
    for (int k = 0; k < kPairs; ++k)
      list.s[k] = s[size_t(slot(k))].data(), list.y[k] = y[size_t(slot(k))].data();
    return list;
  }

  void find_direction(DevicePreconditioner& first, const double* u, double* trial_u);
  void first_loop(DevicePreconditioner& first, const FirstLoop& loop);
  void second_loop(const UnturnedResult& result, const FirstLoop& loop);
  void take_direction(const double* u, double* trial_u);
  void measure_gradient();
  void measure_trial(const double* u, const double* trial_u, const InertiaTerms& inertia);
  /// The trial that was measured last is the new state.
  void accept() {
    std::swap(gradient, trial_gradient);
    if (products.take(numbers[0].pair)) next = (next + 1) % kPairs;
  }

  int64_t size;
  DeviceArray<T> gradient, trial_gradient, direction;
  std::vector<DeviceArray<T>> s, y;
  DeviceArray<double> coefficients;  // c of lbfgs_products.hpp
  DeviceArray<SumRoom<Sums<kPairs>>> pair_sums;
  DeviceArray<SumRoom<Sums<1>>> slope_sums;
  DeviceArray<SumRoom<Sums<kTrialSums>>> trial_sums;
  PinnedArray<Numbers> numbers;
  LbfgsProducts products;
  int next = 0;
};

/// d = H g, its slope, and trial_u = u - d.
template <class T>
void Iteration<T>::find_direction(DevicePreconditioner& first, const double* u, double* trial_u) {
  FirstLoop loop;
  products.first_loop(loop.alpha);
  first_loop(first, loop);
  first.cycle();
  second_loop(first.result(), loop);
  take_direction(u, trial_u);
}

/// q = g - sum alpha_k y_k, on its way into the preconditioner.
template <class T>
void Iteration<T>::first_loop(DevicePreconditioner& first, const FirstLoop& loop) {
  const PairVectors<T> p = pairs();
  const T* g = gradient.data();
  first.turn([=] __device__(int64_t n, float q[3]) {
    double sum[3];
    for (int i = 0; i < 3; ++i) sum[i] = double(g[3 * n + i]);
#pragma unroll
    for (int k = 0; k < kPairs; ++k)
      if (k < p.count)
        for (int i = 0; i < 3; ++i) sum[i] -= loop.alpha[k] * double(p.y[k][3 * n + i]);
    for (int i = 0; i < 3; ++i) q[i] = float(sum[i]);
  });
}

/// d = B q and the coefficients of the s_k.
template <class T>
void Iteration<T>::second_loop(const UnturnedResult& result, const FirstLoop& loop) {
  const PairVectors<T> p = pairs();
  const LbfgsProducts numbers_of_pairs = products;
  T* d = direction.data();
  double* c = coefficients.data();
  ordered_sum(
      size / 3, pair_sums.data(),
      [=] __device__(int64_t n, Sums<kPairs> & sum) {
        T v[3];
        result.at(n, v);
        for (int i = 0; i < 3; ++i) d[3 * n + i] = v[i];
#pragma unroll
        for (int k = 0; k < kPairs; ++k)
          if (k < p.count)
            for (int i = 0; i < 3; ++i) sum.value[k] += double(p.y[k][3 * n + i]) * double(v[i]);
      },
      [=] __device__(const Sums<kPairs>& sum) {
        double found[kPairs];
        numbers_of_pairs.second_loop(loop.alpha, sum.value, found);
        for (int k = 0; k < kPairs; ++k) c[k] = found[k];
      });
}

/// d += sum c_k s_k, its slope, and the trial of the whole step.
template <class T>
void Iteration<T>::take_direction(const double* u, double* trial_u) {
  const PairVectors<T> p = pairs();
  const T* g = gradient.data();
  T* d = direction.data();
  const double* c = coefficients.data();
  Numbers* to = numbers.data();
  ordered_sum(
      size, slope_sums.data(),
      [=] __device__(int64_t i, Sums<1> & sum) {
        double found = double(d[i]);
#pragma unroll
        for (int k = 0; k < kPairs; ++k)
          if (k < p.count) found += __ldg(c + k) * double(p.s[k][i]);
        const T rounded = T(found);
        d[i] = rounded;
        trial_u[i] = u[i] - double(rounded);
        sum.value[0] += double(g[i]) * double(rounded);
      },
      [=] __device__(const Sums<1>& sum) { to->slope = -sum.value[0]; });
}

/// |g|^2.
template <class T>
void Iteration<T>::measure_gradient() {
  const T* g = gradient.data();
  Numbers* to = numbers.data();
  ordered_sum(
      size, slope_sums.data(),
      [=] __device__(int64_t i, Sums<1> & sum) { sum.value[0] += double(g[i]) * double(g[i]); },
      [=] __device__(const Sums<1>& sum) { to->gradient = sum.value[0]; });
}

/// The trial's gradient, slope, inertial energy and pair; the pair takes the place of the oldest.
template <class T>
void Iteration<T>::measure_trial(const double* u, const double* trial_u,
                                 const InertiaTerms& inertia) {
  using Trial = Sums<kTrialSums>;
  const PairVectors<T> p = pairs();
  const int older = products.older();
  const T *g = gradient.data(), *trial_g = trial_gradient.data(), *d = direction.data();
  T *s_n = s[size_t(next)].data(), *y_n = y[size_t(next)].data();
  Numbers* to = numbers.data();
  ordered_sum(
      size, trial_sums.data(),
      [=] __device__(int64_t i, Trial & sum) {
        const T step = T(trial_u[i] - u[i]), change = trial_g[i] - g[i];
        s_n[i] = step, y_n[i] = change;
        const double force = double(trial_g[i]), a = double(step), b = double(change);
        const double found[7] = {force * force, force * double(d[i]),         a * b, a * a, b * b,
                                 a * force,     inertia.energy(i, trial_u[i])};
        for (int k = 0; k < 7; ++k) sum.value[k] += found[k];
#pragma unroll
        for (int k = 0; k < kOlder; ++k) {
          if (k >= older) continue;
          const double s_k = double(p.s[k][i]);
          sum.value[7 + k] += s_k * force, sum.value[7 + kOlder + k] += s_k * b;
        }
      },
      [=] __device__(const Trial& sum) {
        const double* v = sum.value;
        to->gradient = v[0], to->trial_slope = -v[1], *inertia.total = v[6];
        LbfgsProducts::Newest& pair = to->pair;
        pair.sy = v[2], pair.ss = v[3], pair.yy = v[4], pair.sg = v[5];
        for (int k = 0; k < kOlder; ++k)
          pair.older_g[k] = v[7 + k], pair.older_y[k] = v[7 + kOlder + k];
      });
}

}  // namespace

struct DeviceQuasi::Impl {
  explicit Impl(const IncrementalPotential& host)
      : potential(host), u(3 * potential.nodes()), trial_u(u.size()) {}

  template <class T>
  Iteration<T>& iteration();
  template <class T>
  IterationResult solve(double target, int max_outer, const std::function<bool()>& interrupted);
  template <class T>
  bool line_search(Iteration<T>& it, PotentialValue& value, int& evaluations);
  template <class T>
  void move(const Iteration<T>& it, double a);

  DevicePotential potential;
  std::optional<DevicePreconditioner> first;
  DeviceArray<double> u, trial_u;
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

/// Halves the step until Phi falls; the first trial is there.
template <class T>
bool DeviceQuasi::Impl::line_search(Iteration<T>& it, PotentialValue& value, int& evaluations) {
  const double noise = potential.host().noise(value, std::numeric_limits<T>::epsilon());
  DeviceContact* contact = potential.contact();
  if (contact) contact->cut_step(u.data(), trial_u.data());
  double a = 1;
  for (int halvings = 0; halvings <= kMostHalvings; ++halvings, a /= 2) {
    if (halvings > 0) move(it, a);
    potential.start_gradient<T>(trial_u.data(), it.trial_gradient.data());
    it.measure_trial(u.data(), trial_u.data(), potential.inertia_terms());
    synchronise();
    if (contact && halvings == 0) a = contact->share();
    ++evaluations;
    const Numbers& found = it.numbers[0];
    if (!(found.slope < 0)) return false;
    const PotentialValue trial = potential.value();
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
  it.clear();
  IterationResult result;
  potential.start_evaluation<T>(u.data(), it.gradient.data());
  it.measure_gradient();
  synchronise();
  PotentialValue value = potential.value();
  result.inner = 1;
  double residual = std::sqrt(it.numbers[0].gradient), half = 1e300;
  int halved_at = 0;
  while (true) {
    if (residual < half) half = residual / 2, halved_at = result.outer;
    const bool stalled = sizeof(T) == 4 && result.outer - halved_at > kPatience;
    result.converged = residual <= target;
    if (result.converged || stalled || result.outer == max_outer || interrupted()) return result;
    first->update_contact(u.data(), value.contact != 0);
    it.find_direction(*first, u.data(), trial_u.data());
    if (!line_search(it, value, result.inner)) {
      if (it.products.count == 0) return result;
      it.clear();
      continue;
    }
    residual = std::sqrt(it.numbers[0].gradient);
    it.accept();
    std::swap(u, trial_u);
    ++result.outer;
  }
}

DeviceQuasi::DeviceQuasi(const IncrementalPotential& potential, const Preconditioner<float>& first)
    : DeviceQuasi(potential) {
  impl_->first.emplace(impl_->potential, first);
}

DeviceQuasi::DeviceQuasi(const IncrementalPotential& potential)
    : impl_(std::make_unique<Impl>(potential)) {}

DeviceQuasi::~DeviceQuasi() = default;

size_t DeviceQuasi::later_bytes(int64_t nodes) {
  constexpr size_t kVectors = 3 + 2 * kPairs;  // of an iteration; they are made when it comes first
  return 3 * size_t(nodes) * kVectors * (sizeof(float) + sizeof(double)) +
         2 * (sizeof(SumRoom<Sums<kPairs>>) + sizeof(SumRoom<Sums<1>>) +
              sizeof(SumRoom<Sums<kTrialSums>>));
}

DevicePotential& DeviceQuasi::potential() {
  return impl_->potential;
}

DevicePreconditioner& DeviceQuasi::preconditioner() {
  return *impl_->first;
}

double* DeviceQuasi::u() {
  return impl_->u.data();
}

double* DeviceQuasi::trial_u() {
  return impl_->trial_u.data();
}

void DeviceQuasi::accept_trial() {
  std::swap(impl_->u, impl_->trial_u);
}

void DeviceQuasi::set_nodal_rotations() {
  impl_->potential.set_nodal_rotations(impl_->u.data());
}

IterationResult DeviceQuasi::solve(double target, int max_outer, bool float64,
                                   const std::function<bool()>& interrupted) {
  return float64 ? impl_->solve<double>(target, max_outer, interrupted)
                 : impl_->solve<float>(target, max_outer, interrupted);
}

void DeviceQuasi::begin_step() {
  impl_->potential.begin_step();
}

void DeviceQuasi::download_u(double* u) {
  impl_->u.download(u);
}

void DeviceQuasi::update_contact(bool touching) {
  impl_->first->update_contact(impl_->u.data(), touching);
}

void DeviceQuasi::set_nodal_rotations(const double* u) {
  impl_->u.upload(u);
  set_nodal_rotations();
}

IterationResult DeviceQuasi::solve(double* u, double target, int max_outer, bool float64,
                                   const std::function<bool()>& interrupted) {
  impl_->u.upload(u);
  const IterationResult result = solve(target, max_outer, float64, interrupted);
  impl_->u.download(u);
  return result;
}

template <class T>
void DeviceQuasi::precondition(const T* r, T* z) {
  DevicePreconditioner& first = *impl_->first;
  first.turn([=] __device__(int64_t n, float v[3]) {
    for (int i = 0; i < 3; ++i) v[i] = float(r[3 * n + i]);
  });
  first.cycle();
  const UnturnedResult result = first.result();
  cuda::for_each(impl_->potential.nodes(), [=] __device__(int64_t n) { result.at(n, z + 3 * n); });
}

template void DeviceQuasi::precondition(const float*, float*);
template void DeviceQuasi::precondition(const double*, double*);

}  // namespace elastogen::cuda
