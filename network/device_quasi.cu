// SPDX-License-Identifier: Apache-2.0
#include "core/device_reduce.cuh"
#include "core/device_wide.cuh"
#include "core/line_search.hpp"
#include "network/device_lbfgs.cuh"
#include "network/device_preconditioner.cuh"
#include "network/device_quasi.hpp"

#include <cmath>
#include <limits>
#include <optional>

namespace elastogen::cuda {
namespace {

constexpr int kPatience = 25;  // iterations, as on the CPU
constexpr int kMostHalvings = 12, kTrialSums = 6 + 2 * kOlder;

/// The gradients of an iteration in T; lbfgs.hpp on the device.
template <class T>
struct Iteration {
  Iteration(int64_t n, Pairs& of)
      : size(n),
        pairs(of),
        gradient(n),
        trial_gradient(n),
        coefficients(kPairs),
        pair_sums(1),
        slope_sums(1),
        trial_sums(1),
        numbers(1) {}

  void clear() { pairs.products.count = 0; }

  void find_step(DevicePreconditioner& first, const double* u, double* trial_u);
  void first_loop(DevicePreconditioner& first, const FirstLoop& loop);
  void second_loop(const UnturnedResult& result, const FirstLoop& loop);
  void take_step(const double* u, double* trial_u);
  void halve_step(const double* u, double* trial_u);
  void take_cut_step(const double* u, const double* trial_u);
  void measure_gradient();
  void measure_trial(const double* trial_u, const InertiaTerms& inertia);
  /// The trial that was measured last is the new state.
  void accept() {
    std::swap(gradient, trial_gradient);
    pairs.take(numbers[0].pair);
  }

  int64_t size;
  Pairs& pairs;
  DeviceArray<T> gradient, trial_gradient;
  DeviceArray<double> coefficients;  // c of lbfgs_products.hpp
  DeviceArray<SumRoom<Sums<kPairs>>> pair_sums;
  DeviceArray<SumRoom<Sums<1>>> slope_sums;
  DeviceArray<SumRoom<Sums<kTrialSums>>> trial_sums;
  PinnedArray<Numbers> numbers;
};

/// p = -H g, its slope, and trial_u = u + p.
template <class T>
void Iteration<T>::find_step(DevicePreconditioner& first, const double* u, double* trial_u) {
  FirstLoop loop;
  pairs.products.first_loop(loop.alpha);
  first_loop(first, loop);
  first.cycle();
  second_loop(first.result(), loop);
  take_step(u, trial_u);
}

/// q = g - sum alpha_k y_k, on its way into the preconditioner.
template <class T>
void Iteration<T>::first_loop(DevicePreconditioner& first, const FirstLoop& loop) {
  const PairViews list = pairs.views();
  const T* g = gradient.data();
  first.turn([=] __device__(int64_t n, float q[3]) {
    double sum[3];
    for (int i = 0; i < 3; ++i) sum[i] = double(g[3 * n + i]);
#pragma unroll
    for (int k = 0; k < kPairs; ++k)
      if (k < list.count)
        for (int i = 0; i < 3; ++i) sum[i] -= loop.alpha[k] * double(list.y[k][3 * n + i]);
    for (int i = 0; i < 3; ++i) q[i] = float(sum[i]);
  });
}

/// -B q in the place of p, and the coefficients of the s_k.
template <class T>
void Iteration<T>::second_loop(const UnturnedResult& result, const FirstLoop& loop) {
  const PairViews list = pairs.views();
  const LbfgsProducts products = pairs.products;
  float* p = pairs.step();
  double* c = coefficients.data();
  ordered_sum(
      size / 3, pair_sums.data(),
      [=] __device__(int64_t n, Sums<kPairs> & sum) {
        float v[3];
        result.at(n, v);
        for (int i = 0; i < 3; ++i) p[3 * n + i] = -v[i];
#pragma unroll
        for (int k = 0; k < kPairs; ++k)
          if (k < list.count)
            for (int i = 0; i < 3; ++i) sum.value[k] += double(list.y[k][3 * n + i]) * double(v[i]);
      },
      [=] __device__(const Sums<kPairs>& sum) {
        double found[kPairs];
        products.second_loop(loop.alpha, sum.value, found);
        for (int k = 0; k < kPairs; ++k) c[k] = found[k];
      });
}

/// p -= sum c_k s_k, its slope, and the trial of the whole step.
template <class T>
void Iteration<T>::take_step(const double* u, double* trial_u) {
  const PairViews list = pairs.views();
  const T* g = gradient.data();
  float* p = pairs.step();
  const double* c = coefficients.data();
  Numbers* to = numbers.data();
  const int64_t n = size;
  ordered_sum(
      Wide<4>::parts(n), slope_sums.data(),
      [=] __device__(int64_t part, Sums<1> & sum) {
        const Wide<4> at(part, n);
        float step[4], s_k[4];
        double found[4], place[4];
        T force[4];
        at.load(p, step), at.load(u, place), at.load(g, force);
        for (int j = 0; j < 4; ++j) found[j] = double(step[j]);
#pragma unroll
        for (int k = 0; k < kPairs; ++k) {
          if (k >= list.count) continue;
          at.load(list.s[k], s_k);
          for (int j = 0; j < 4; ++j) found[j] -= __ldg(c + k) * double(s_k[j]);
        }
        for (int j = 0; j < 4; ++j) {
          step[j] = float(found[j]);
          place[j] += double(step[j]);
          sum.value[0] += double(force[j]) * double(step[j]);
        }
        at.store(step, p), at.store(place, trial_u);
      },
      [=] __device__(const Sums<1>& sum) { to->slope = sum.value[0]; });
}

template <class T>
void Iteration<T>::halve_step(const double* u, double* trial_u) {
  float* p = pairs.step();
  cuda::for_each(size, [=] __device__(int64_t i) {
    p[i] /= 2;
    trial_u[i] = u[i] + double(p[i]);
  });
}

/// p = trial_u - u, where colliders have cut the step.
template <class T>
void Iteration<T>::take_cut_step(const double* u, const double* trial_u) {
  float* p = pairs.step();
  cuda::for_each(size, [=] __device__(int64_t i) { p[i] = float(trial_u[i] - u[i]); });
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
void Iteration<T>::measure_trial(const double* trial_u, const InertiaTerms& inertia) {
  using Trial = Sums<kTrialSums>;
  const PairViews list = pairs.views();
  const int older = pairs.products.older();
  const T *g = gradient.data(), *trial_g = trial_gradient.data();
  const float* p = pairs.step();
  float* y = pairs.next_difference();
  Numbers* to = numbers.data();
  const int64_t n = size;
  ordered_sum(
      Wide<2>::parts(n), trial_sums.data(),
      [=] __device__(int64_t part, Trial & sum) {
        const Wide<2> at(part, n);
        T force[2], before[2];
        float step[2], change[2], s_k[2];
        double place[2];
        at.load(trial_g, force), at.load(g, before), at.load(p, step), at.load(trial_u, place);
        for (int j = 0; j < 2; ++j) {
          change[j] = float(force[j] - before[j]);
          const double f = double(force[j]), a = double(step[j]), b = double(change[j]);
          const double found[5] = {f * f, a * f, a * b, a * a, b * b};
          for (int k = 0; k < 5; ++k) sum.value[k] += found[k];
          if (j < at.count) sum.value[5] += inertia.energy(at.first + j, place[j]);
        }
        at.store(change, y);
#pragma unroll
        for (int k = 0; k < kOlder; ++k) {
          if (k >= older) continue;
          at.load(list.s[k], s_k);
          for (int j = 0; j < 2; ++j) {
            sum.value[6 + k] += double(s_k[j]) * double(force[j]);
            sum.value[6 + kOlder + k] += double(s_k[j]) * double(change[j]);
          }
        }
      },
      [=] __device__(const Trial& sum) {
        const double* v = sum.value;
        to->gradient = v[0], *inertia.total = v[5];
        LbfgsProducts::Newest& pair = to->pair;
        pair.sg = v[1], pair.sy = v[2], pair.ss = v[3], pair.yy = v[4];
        for (int k = 0; k < kOlder; ++k)
          pair.older_g[k] = v[6 + k], pair.older_y[k] = v[6 + kOlder + k];
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
  DevicePotential potential;
  std::optional<DevicePreconditioner> first;
  DeviceArray<double> u, trial_u;
  std::optional<Pairs> pairs;
  std::optional<Iteration<float>> single;
  std::optional<Iteration<double>> precise;
};

template <class T>
Iteration<T>& DeviceQuasi::Impl::iteration() {
  if (!pairs) pairs.emplace(u.size());
  const auto made = [&](auto& of) -> auto& {
    return of ? *of : of.emplace(u.size(), *pairs);
  };
  if constexpr (sizeof(T) == 4)
    return made(single);
  else
    return made(precise);
}

/// Halves the step until Phi falls; the first trial is there.
template <class T>
bool DeviceQuasi::Impl::line_search(Iteration<T>& it, PotentialValue& value, int& evaluations) {
  const double noise = potential.host().noise(value, std::numeric_limits<T>::epsilon());
  DeviceContact* contact = potential.contact();
  if (contact) {
    contact->cut_step(u.data(), trial_u.data());
    it.take_cut_step(u.data(), trial_u.data());
  }
  double a = 1;
  for (int halvings = 0; halvings <= kMostHalvings; ++halvings, a /= 2) {
    if (halvings > 0) it.halve_step(u.data(), trial_u.data());
    potential.start_gradient<T>(trial_u.data(), it.trial_gradient.data());
    it.measure_trial(trial_u.data(), potential.inertia_terms());
    synchronise();
    if (contact && halvings == 0) a = contact->share();
    ++evaluations;
    const Numbers& found = it.numbers[0];
    if (!(found.slope < 0)) return false;
    const PotentialValue trial = potential.value();
    const double difference = trial.total() - value.total(), slope = found.pair.sg;
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
    it.find_step(*first, u.data(), trial_u.data());
    if (!line_search(it, value, result.inner)) {
      if (it.pairs.products.count == 0) return result;
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
  // of pairs and iterations; they are made when they come first
  constexpr size_t kFloats = 2 * kPairs + 1 + 2, kDoubles = 2;
  return 3 * size_t(nodes) * (kFloats * sizeof(float) + kDoubles * sizeof(double)) +
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
