// SPDX-License-Identifier: Apache-2.0
#include "core/cuda/reduce.cuh"
#include "core/cuda/signal.cuh"
#include "core/line_search.hpp"
#include "network/device_newton.hpp"
#include "network/device_preconditioner.cuh"
#include "network/newton_solver.hpp"

#include <cmath>
#include <limits>

namespace elastogen::cuda {
namespace {

constexpr size_t kDoubles = 3, kFloats = 5;  // vectors

/// What the host asks for.
struct HostNumbers {
  double square;   ///< |g|^2 or |r|^2
  double slope;    ///< g . step
  PcgScalars pcg;  ///< after the present iteration
};

}  // namespace

struct DeviceNewton::Impl {
  explicit Impl(DeviceQuasi& q)
      : quasi(q),
        potential(q.potential()),
        size(3 * potential.nodes()),
        trial_u(size),
        gradient(size),
        trial_gradient(size),
        x(size),
        r(size),
        z(size),
        p(size),
        Ap(size),
        pcg(1),
        sums(1),
        pair_sums(1),
        numbers(1) {}

  // one pass each
  void measure(const DeviceArray<double>& g);
  void start_pcg(double unit, const PcgScalars& scalars);
  void find_direction();
  void find_curvature();
  void advance();
  void scale_step(double unit);
  void move(double a);

  int solve_linear(double unit, double eta, int most, const std::function<bool()>& interrupted);
  void line_search(PotentialValue& value);

  DeviceQuasi& quasi;
  DevicePotential& potential;
  int64_t size;
  DeviceArray<double> trial_u, gradient, trial_gradient;
  DeviceArray<float> x, r, z, p, Ap;  // x is the step
  DeviceArray<PcgScalars> pcg;
  DeviceArray<SumRoom<Sums<1>>> sums;
  DeviceArray<SumRoom<Sums<2>>> pair_sums;
  PinnedArray<HostNumbers> numbers;
  Signal signal;  // of numbers
  NewtonRegion region;
  StepTaken taken;  // by the line search
};

/// |g|^2 and its slope along the step.
void DeviceNewton::Impl::measure(const DeviceArray<double>& g) {
  const double* values = g.data();
  const float* step = x.data();
  HostNumbers* to = numbers.data();
  const Signal::Raise raise = signal.next();
  ordered_sum(
      size, pair_sums.data(),
      [=] __device__(int64_t k, Sums<2> & sum) {
        sum.value[0] += values[k] * values[k];
        sum.value[1] += values[k] * double(step[k]);
      },
      [=] __device__(const Sums<2>& sum) {
        to->square = sum.value[0], to->slope = sum.value[1];
        raise();
      });
}

/// r = -g/unit, x = 0, and |r|^2; the scalars go to the device.
void DeviceNewton::Impl::start_pcg(double unit, const PcgScalars& scalars) {
  const double* g = gradient.data();
  float *to_r = r.data(), *to_x = x.data();
  HostNumbers* to = numbers.data();
  PcgScalars* of = pcg.data();
  const Signal::Raise raise = signal.next();
  ordered_sum(
      size, sums.data(),
      [=] __device__(int64_t k, Sums<1> & sum) {
        const float right = float(-g[k] / unit);
        to_r[k] = right;
        to_x[k] = 0;
        sum.value[0] += double(right) * double(right);
      },
      [=] __device__(const Sums<1>& sum) {
        to->square = sum.value[0], *of = scalars;
        raise();
      });
}

/// z = B r and p = z + beta p.
void DeviceNewton::Impl::find_direction() {
  DevicePreconditioner& B = quasi.preconditioner();
  float *residual = r.data(), *preconditioned = z.data(), *direction = p.data();
  B.turn([=] __device__(int64_t n, float v[3]) {
    for (int i = 0; i < 3; ++i) v[i] = residual[3 * n + i];
  });
  B.cycle();
  const UnturnedResult result = B.result();
  PcgScalars* of = pcg.data();
  ordered_sum(
      size / 3, sums.data(),
      [=] __device__(int64_t n, Sums<1> & sum) {
        float v[3];
        result.at(n, v);
        for (int i = 0; i < 3; ++i) {
          preconditioned[3 * n + i] = v[i];
          sum.value[0] += double(residual[3 * n + i]) * double(v[i]);
        }
      },
      [=] __device__(const Sums<1>& sum) { of->turn(sum.value[0]); });
  cuda::for_each(size, [=] __device__(int64_t k) {
    const float beta = float(of->beta);
    direction[k] = beta == 0 ? preconditioned[k] : preconditioned[k] + beta * direction[k];
  });
}

/// A p and p . A p.
void DeviceNewton::Impl::find_curvature() {
  potential.hessian_product(p.data(), Ap.data());
  const float *direction = p.data(), *product = Ap.data();
  PcgScalars* of = pcg.data();
  ordered_sum(
      size, sums.data(),
      [=] __device__(int64_t k, Sums<1> & sum) {
        sum.value[0] += double(direction[k]) * double(product[k]);
      },
      [=] __device__(const Sums<1>& sum) { of->advance(sum.value[0]); });
}

/// x += alpha p, r -= alpha A p and |r|^2.
void DeviceNewton::Impl::advance() {
  const float *direction = p.data(), *product = Ap.data();
  float *to_x = x.data(), *to_r = r.data();
  PcgScalars* of = pcg.data();
  HostNumbers* to = numbers.data();
  const Signal::Raise raise = signal.next();
  ordered_sum(
      size, sums.data(),
      [=] __device__(int64_t k, Sums<1> & sum) {
        const float alpha = float(of->alpha);
        if (alpha != 0) to_x[k] += alpha * direction[k];
        const float left = alpha != 0 ? to_r[k] - alpha * product[k] : to_r[k];
        to_r[k] = left;
        sum.value[0] += double(left) * double(left);
      },
      [=] __device__(const Sums<1>& sum) {
        to->square = sum.value[0], to->pcg = *of;
        raise();
      });
}

/// The PCG of core/pcg.hpp for the step in units of `unit`; gives its iterations.
int DeviceNewton::Impl::solve_linear(double unit, double eta, int most,
                                     const std::function<bool()>& interrupted) {
  start_pcg(unit, region.scalars(unit));
  signal.wait();
  const double start = std::sqrt(numbers[0].square);
  double residual = start > 0 ? 1 : 0;
  int iterations = 0;
  numbers[0].pcg = {};
  while (residual > eta && iterations < most && !numbers[0].pcg.ended && !interrupted()) {
    find_direction();
    find_curvature();
    advance();
    signal.wait();
    if (numbers[0].pcg.alpha == 0) break;
    residual = std::sqrt(numbers[0].square) / start;
    ++iterations;
  }
  return iterations;
}

void DeviceNewton::Impl::scale_step(double unit) {
  float* step = x.data();
  cuda::for_each(size, [=] __device__(int64_t k) { step[k] *= float(unit); });
}

/// trial_u = u + a step.
void DeviceNewton::Impl::move(double a) {
  const double* from = quasi.u();
  const float* step = x.data();
  double* to = trial_u.data();
  cuda::for_each(size, [=] __device__(int64_t k) { to[k] = from[k] + a * double(step[k]); });
}

/// Moves u along the step where Phi falls; taken says how far, gradient and value follow.
void DeviceNewton::Impl::line_search(PotentialValue& value) {
  measure(gradient);
  signal.wait();
  const double slope = numbers[0].slope;
  const double noise = potential.terms().noise(value, std::numeric_limits<double>::epsilon());
  taken = {slope, noise};
  if (!(slope < 0)) return;
  DeviceContact* contact = potential.contact();
  PotentialValue there;
  const auto found = backtrack([&](double a, int halvings) {
    const bool cut = contact && halvings == 0;
    move(a);
    if (cut) contact->cut_step(quasi.u(), trial_u.data());
    potential.start_evaluation<double>(trial_u.data(), trial_gradient.data());
    measure(trial_gradient);
    signal.wait();
    if (cut) a = contact->share();
    there = potential.value();
    return LineTrial{.share = a,
                     .difference = there.total() - value.total(),
                     .slope_start = slope,
                     .slope_end = a * numbers[0].slope,
                     .noise = noise};
  });
  if (!found) return;
  check(cudaMemcpyAsync(quasi.u(), trial_u.data(), size_t(size) * sizeof(double),
                        cudaMemcpyDeviceToDevice, cudaStreamPerThread));
  std::swap(gradient, trial_gradient);
  value = there;
  taken = {slope, noise, found->change(), found->share, found->halvings > 0};
}

DeviceNewton::DeviceNewton(DeviceQuasi& quasi) : impl_(std::make_unique<Impl>(quasi)) {}

DeviceNewton::~DeviceNewton() = default;

IterationResult DeviceNewton::solve(double target, int max_outer, int max_inner,
                                    const std::function<bool()>& interrupted) {
  Impl& s = *impl_;
  IterationResult result;
  s.potential.start_evaluation<double>(s.quasi.u(), s.gradient.data());
  s.measure(s.gradient);
  s.signal.wait();
  PotentialValue value = s.potential.value();
  double residual = std::sqrt(s.numbers[0].square), before = 0, eta = 0.1;
  NewtonRegion& region = s.region;
  region.begin();
  while (true) {
    result.converged = residual <= target;
    result.bounded = region.bounded();
    if (result.converged || result.outer >= region.most_steps(max_outer) || interrupted())
      return result;
    s.potential.linearise(s.quasi.u(), region.tangent(), value.contact != 0);
    s.quasi.preconditioner().take_contact();
    eta = forcing_term(residual, before, eta, target);
    before = residual;
    const double unit = residual / std::sqrt(double(s.size));  // as on the host
    result.inner += std::max(s.solve_linear(unit, eta, max_inner, interrupted), 1);
    const PcgScalars end = s.numbers[0].pcg;
    s.scale_step(unit);
    ++result.outer;
    s.line_search(value);
    if (!region.take_step(end, unit, s.taken)) return result;
    if (s.taken.share > 0) residual = std::sqrt(s.numbers[0].square);
  }
}

size_t DeviceNewton::bytes(const DevicePotential& potential) {
  return 3 * size_t(potential.nodes()) * (kDoubles * sizeof(double) + kFloats * sizeof(float)) +
         sizeof(SumRoom<Sums<1>>) + sizeof(SumRoom<Sums<2>>) + sizeof(PcgScalars) +
         potential.tangent_bytes();
}

}  // namespace elastogen::cuda
