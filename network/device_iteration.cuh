// SPDX-License-Identifier: Apache-2.0
// The passes over the vectors of an iteration of L-BFGS on the device (device_lbfgs.cuh): before
// and after the first matrix, the step, and what is measured of a trial.

#pragma once

#include "core/device_reduce.cuh"
#include "core/device_wide.cuh"
#include "network/device_lbfgs.cuh"
#include "network/device_potential.hpp"
#include "network/device_preconditioner.cuh"

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
        pair_sums(1),
        slope_sums(1),
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
  DeviceArray<SumRoom<Sums<kPairs>>> pair_sums;
  DeviceArray<SumRoom<Sums<1>>> slope_sums;
  DeviceArray<SumRoom<Sums<kGradientSums>>> gradient_sums;
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
        for (int i = 0; i < 3; ++i) sum[i] -= loop.alpha[k] * double(float(list.y[k][3 * n + i]));
    for (int i = 0; i < 3; ++i) q[i] = float(sum[i]);
  });
}

/// -B q in the place of p, and the coefficients of the s_k.
template <class T>
void Iteration<T>::second_loop(const UnturnedResult& result, const FirstLoop& loop) {
  const PairViews list = pairs.views();
  const LbfgsProducts products = pairs.products;
  float* p = pairs.step.data();
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
            for (int i = 0; i < 3; ++i)
              sum.value[k] += double(float(list.y[k][3 * n + i])) * double(v[i]);
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
  float* p = pairs.step.data();
  const double* c = coefficients.data();
  Numbers* to = numbers.data();
  const int64_t n = size;
  ordered_sum(
      Wide<4>::parts(n), slope_sums.data(),
      [=] __device__(int64_t part, Sums<1> & sum) {
        const Wide<4> at(part, n);
        float step[4];
        PairNumber s_k[4];
        double found[4], place[4];
        T force[4];
        at.load(p, step), at.load(u, place), at.load(g, force);
        for (int j = 0; j < 4; ++j) found[j] = double(step[j]);
#pragma unroll
        for (int k = 0; k < kPairs; ++k) {
          if (k >= list.count) continue;
          at.load(list.s[k], s_k);
          for (int j = 0; j < 4; ++j) found[j] -= c[k] * double(float(s_k[j]));
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
      });
}

/// The trial's gradient, slope, inertial energy and pair; the pair takes the place of the oldest.
template <class T>
void Iteration<T>::measure_trial(const double* trial_u, const InertiaTerms& inertia) {
  using Trial = Sums<kTrialSums>;
  constexpr int kAtOnce = 4;
  const PairViews list = pairs.views();
  const int older = pairs.products.older();
  const T *g = gradient.data(), *trial_g = trial_gradient.data();
  const float* p = pairs.step.data();
  PairNumber *s = pairs.next_s(), *y = pairs.next_y();
  Numbers* to = numbers.data();
  const int64_t n = size;
  ordered_sum(
      Wide<kAtOnce>::parts(n), trial_sums.data(),
      [=] __device__(int64_t part, Trial & sum) {
        const Wide<kAtOnce> at(part, n);
        T force[kAtOnce], before[kAtOnce];
        float step[kAtOnce];
        PairNumber taken[kAtOnce], change[kAtOnce], s_k[kAtOnce];
        double place[kAtOnce];
        at.load(trial_g, force), at.load(g, before), at.load(p, step), at.load(trial_u, place);
        for (int j = 0; j < kAtOnce; ++j) {
          taken[j] = step[j], change[j] = float(force[j] - before[j]);
          const double f = double(force[j]), a = double(float(taken[j]));
          const double b = double(float(change[j])), slope = f * double(step[j]);
          const double found[6] = {f * f, slope, a * f, a * b, a * a, b * b};
          for (int k = 0; k < 6; ++k) sum.value[k] += found[k];
          if (j < at.count) sum.value[6] += inertia.energy(at.first + j, place[j]);
        }
        at.store(taken, s), at.store(change, y);
#pragma unroll
        for (int k = 0; k < kOlder; ++k) {
          if (k >= older) continue;
          at.load(list.s[k], s_k);
          for (int j = 0; j < kAtOnce; ++j) {
            const double of = double(float(s_k[j]));
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
      });
}

}  // namespace elastogen::cuda
