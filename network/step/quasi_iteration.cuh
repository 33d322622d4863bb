// SPDX-License-Identifier: Apache-2.0
// The passes over the vectors of an iteration of L-BFGS on the device (lbfgs.cuh): before
// and after the first matrix, the step, and what is measured of a trial.

#pragma once

#include "core/cuda/signal.cuh"
#include "core/cuda/wide.cuh"
#include "network/potential/incremental_potential_device.hpp"
#include "network/precondition/preconditioner.cuh"
#include "network/step/lbfgs.cuh"

namespace elastogen::cuda {

inline constexpr int kTrialSums = 7 + 2 * kOlder, kGradientSums = 1 + kPairs;

/// The gradients of an iteration in T; lbfgs.hpp on the device.
template <class T>
struct Iteration {
  Iteration(int64_t n, Pairs& of)
      : size(n),
        pairs(of),
        gradient(n),
        trial_gradient(n),
        coefficients(kPairs),
        step_sums(1),
        gradient_sums(1),
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
  void take_gradient() { std::copy_n(numbers[0].of_pairs, kPairs, pairs.products.sg); }
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
  DeviceArray<SumScratch<Sums<kPairs + 1>>> step_sums;
  DeviceArray<SumScratch<Sums<kGradientSums>>> gradient_sums;
  DeviceArray<SumScratch<Sums<kTrialSums>>> trial_sums;
  PinnedArray<Numbers> numbers;
  Signal signal;  // of numbers
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
        for (int i = 0; i < 3; ++i) sum[i] -= loop.alpha[k] * double(float(list.y[k][3 * n + i]));
    for (int i = 0; i < 3; ++i) q[i] = float(sum[i]);
  });
}

/// -B q in the place of p, the coefficients c_k of the s_k, and the slope g.p of p = -B q - sum c_k
/// s_k.
template <class T>
void Iteration<T>::second_loop(const UnturnedResult& result, const FirstLoop& loop) {
  using Found = Sums<kPairs + 1>;
  const PairViews list = pairs.views();
  const LbfgsProducts products = pairs.products;
  const T* g = gradient.data();
  float* p = pairs.step.data();
  double* c = coefficients.data();
  Numbers* to = numbers.data();
  ordered_sum(
      size / 3, step_sums.data(),
      [=] __device__(int64_t n, Found & sum) {
        float y[kPairs][3], v[3];
        T force[3];
#pragma unroll
        for (int k = 0; k < kPairs; ++k)
          for (int i = 0; i < 3; ++i) y[k][i] = k < list.count ? float(list.y[k][3 * n + i]) : 0;
        for (int i = 0; i < 3; ++i) force[i] = g[3 * n + i];
        // p = -B q, its slope and the products with the pairs
        result.at(n, v);
        for (int i = 0; i < 3; ++i) {
          p[3 * n + i] = -v[i];
          sum.value[kPairs] += double(force[i]) * double(v[i]);
        }
#pragma unroll
        for (int k = 0; k < kPairs; ++k)
          for (int i = 0; i < 3; ++i) sum.value[k] += double(y[k][i]) * double(v[i]);
      },
      [=] __device__(const Found& sum) {
        double found[kPairs], slope = -sum.value[kPairs];
        products.second_loop(loop.alpha, sum.value, found);
        for (int k = 0; k < kPairs; ++k) {
          c[k] = found[k];
          if (k < products.count) slope -= found[k] * products.sg[k];
        }
        to->slope = slope;
      });
}

/// p -= sum c_k s_k, and the trial of the whole step.
template <class T>
void Iteration<T>::take_step(const double* u, double* trial_u) {
  const PairViews list = pairs.views();
  float* p = pairs.step.data();
  const double* c = coefficients.data();
  for_each_wide<4>(size, [=] __device__(const auto& at) {
    constexpr int kCount = std::decay_t<decltype(at)>::kCount;
    float step[kCount];
    PairNumber s[kPairs][kCount];
    double found[kCount], place[kCount];
    at.load(p, step), at.load(u, place);
#pragma unroll
    for (int k = 0; k < kPairs; ++k)
      if (k < list.count) at.load(list.s[k], s[k]);
    // p - sum c_k s_k in double
    for (int j = 0; j < kCount; ++j) found[j] = double(step[j]);
#pragma unroll
    for (int k = 0; k < kPairs; ++k)
      if (k < list.count)
        for (int j = 0; j < kCount; ++j) found[j] -= c[k] * double(float(s[k][j]));
    for (int j = 0; j < kCount; ++j) {
      step[j] = float(found[j]);
      place[j] += double(step[j]);
    }
    at.store(step, p), at.store(place, trial_u);
  });
}

template <class T>
void Iteration<T>::halve_step(const double* u, double* trial_u) {
  float* p = pairs.step.data();
  cuda::for_each(size, [=] __device__(int64_t i) {
    p[i] /= 2;
    trial_u[i] = u[i] + double(p[i]);
  });
}

/// p = trial_u - u, where colliders have cut the step.
template <class T>
void Iteration<T>::take_cut_step(const double* u, const double* trial_u) {
  float* p = pairs.step.data();
  cuda::for_each(size, [=] __device__(int64_t i) { p[i] = float(trial_u[i] - u[i]); });
}

/// |g|^2, and products with the pairs that are there.
template <class T>
void Iteration<T>::measure_gradient() {
  using Found = Sums<kGradientSums>;
  const PairViews list = pairs.views();
  const T* g = gradient.data();
  Numbers* to = numbers.data();
  const Signal::Raise raise = signal.next();
  ordered_sum(
      size, gradient_sums.data(),
      [=] __device__(int64_t i, Found & sum) {
        const double force = double(g[i]);
        sum.value[0] += force * force;
#pragma unroll
        for (int k = 0; k < kPairs; ++k)
          if (k < list.count) sum.value[1 + k] += double(float(list.s[k][i])) * force;
      },
      [=] __device__(const Found& sum) {
        to->gradient = sum.value[0];
        for (int k = 0; k < kPairs; ++k) to->of_pairs[k] = sum.value[1 + k];
        raise();
      });
}

/// The trial's gradient, slope, inertial energy and pair; the pair takes the place of the oldest.
template <class T>
void Iteration<T>::measure_trial(const double* trial_u, const InertiaTerms& inertia) {
  using Trial = Sums<kTrialSums>;
  const PairViews list = pairs.views();
  const int older = pairs.products.older();
  const T *g = gradient.data(), *trial_g = trial_gradient.data();
  const float* p = pairs.step.data();
  PairNumber *to_s = pairs.next_s(), *to_y = pairs.next_y();
  Numbers* to = numbers.data();
  const Signal::Raise raise = signal.next();
  ordered_wide_sum<4>(
      size, trial_sums.data(),
      [=] __device__(const auto& at, Trial& sum) {
        constexpr int kCount = std::decay_t<decltype(at)>::kCount;
        T force[kCount], before[kCount];
        float step[kCount];
        PairNumber taken[kCount], change[kCount], s[kOlder][kCount];
        double place[kCount], aim[kCount];
        at.load(g, before), at.load(p, step), at.load(trial_u, place);
        at.load(inertia.predictor, aim), at.load(trial_g, force);
#pragma unroll
        for (int k = 0; k < kOlder; ++k)
          if (k < older) at.load(list.s[k], s[k]);
        // the new pair, and its products with the gradient and with itself
        for (int j = 0; j < kCount; ++j) {
          taken[j] = step[j], change[j] = float(force[j] - before[j]);
          const double f = double(force[j]), a = double(float(taken[j]));
          const double b = double(float(change[j])), slope = f * double(step[j]);
          const double found[6] = {f * f, slope, a * f, a * b, a * a, b * b};
          for (int k = 0; k < 6; ++k) sum.value[k] += found[k];
        }
        sum.value[6] += inertia.energy<kCount>(at.first, place, aim);
        at.store(taken, to_s), at.store(change, to_y);
    // its products with the older pairs
#pragma unroll
        for (int k = 0; k < kOlder; ++k) {
          if (k >= older) continue;
          for (int j = 0; j < kCount; ++j) {
            const double of = double(float(s[k][j]));
            sum.value[7 + k] += of * double(force[j]);
            sum.value[7 + kOlder + k] += of * double(float(change[j]));
          }
        }
      },
      [=] __device__(const Trial& sum) {
        const double* v = sum.value;
        to->gradient = v[0], to->trial_slope = v[1], *inertia.total = v[6];
        LbfgsProducts::Newest& pair = to->pair;
        pair.sg = v[2], pair.sy = v[3], pair.ss = v[4], pair.yy = v[5];
        for (int k = 0; k < kOlder; ++k)
          pair.older_g[k] = v[7 + k], pair.older_y[k] = v[7 + kOlder + k];
        raise();
      });
}

}  // namespace elastogen::cuda
