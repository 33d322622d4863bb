// SPDX-License-Identifier: Apache-2.0
#include "core/cuda/graph.cuh"
#include "core/cuda/held_nodes.cuh"
#include "core/cuda/reduce.cuh"
#include "core/cuda/signal.cuh"
#include "core/time_error.hpp"
#include "network/potential/incremental_potential.cuh"
#include "network/precondition/fold_patch_device.hpp"
#include "network/precondition/preconditioner.cuh"
#include "network/step/newton_loop.hpp"
#include "network/step/newton_solver_device.hpp"

#include <cmath>
#include <limits>

namespace elastogen::cuda {
namespace {

constexpr size_t kDoubles = 3, kFloats = 5;  // vectors

/// What the launches of a PCG iteration depend on, beside the memory that they work on.
struct PassKind {
  bool is_stiff = false, has_added = false;  // contact, operators of the preconditioner
  double rate = 0;                           // of damping
  float scale = 0;                           // of the preconditioner
  bool operator==(const PassKind&) const = default;
};

/// Numbers that kernels leave for the host.
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
        count(3 * potential.nodes()),
        trial_u(count),
        gradient(count),
        trial_gradient(count),
        x(count),
        r(count),
        z(count),
        p(count),
        Ap(count),
        pcg(1),
        sums(1),
        pair_sums(1),
        numbers(1),
        folds(potential) {}

  // one pass each
  void measure(const DeviceArray<double>& g);
  void start_pcg(double unit, const PcgScalars& scalars);
  LinearResult run_pcg(double unit, double eta, int most, const PcgScalars& scalars,
                       const Interrupted& interrupted);
  void find_direction();
  void precondition();
  void find_curvature();
  void advance();
  void iterate();
  PassKind pass_kind() const;
  void scale_step(double unit);
  void set_inertial_gradient(const double* y);
  void take_step(double* y);

  // NewtonWork of the card: the trial is u + share d, d in x
  double begin(PotentialValue& value);
  void linearise(TangentKind kind, const PotentialValue& value);
  LinearResult solve(double unit, double eta, int most, const PcgScalars& scalars,
                     const Interrupted& interrupted) {
    const LinearResult result = run_pcg(unit, eta, most, scalars, interrupted);
    watch.take(result.iterations, !folds.empty());
    return result;
  }
  double slope();
  void move(double share, bool is_first);
  void start_trial();
  TrialNumbers wait();
  double accept();
  int64_t size() const { return count; }
  const PotentialTerms& terms() const { return potential.terms(); }

  DeviceQuasi& quasi;
  DevicePotential& potential;
  int64_t count;  // numbers of a vector
  DeviceArray<double> trial_u, gradient, trial_gradient;
  DeviceArray<float> x, r, z, p, Ap;  // x is the step
  DeviceArray<PcgScalars> pcg;
  DeviceArray<SumScratch<Sums<1>>> sums;
  DeviceArray<SumScratch<Sums<2>>> pair_sums;
  PinnedArray<HostNumbers> numbers;
  Signal signal;          // of numbers
  RepeatedSignal passed;  // of those after a PCG iteration
  DeviceGraph pass;       // a PCG iteration without folds
  PassKind recorded;      // its kind
  NewtonRegion region;
  DeviceFoldPatch folds;
  FoldWatch watch;
  TrialNumbers trial;
  bool is_cut = false;  // the trial, where colliders are met
};

/// |g|^2 and its slope along the step.
void DeviceNewton::Impl::measure(const DeviceArray<double>& g) {
  const double* values = g.data();
  const float* step = x.data();
  HostNumbers* to = numbers.data();
  const Signal::Raise raise = signal.next();
  ordered_sum(
      count, pair_sums.data(),
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
      count, sums.data(),
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

/// z = B r and r . z, from which beta follows.
void DeviceNewton::Impl::precondition() {
  DevicePreconditioner& B = quasi.preconditioner();
  const bool folded = !folds.empty();
  float *residual = r.data(), *preconditioned = z.data();
  const float* argument = folded ? folds.begin(residual) : residual;
  B.turn([=] __device__(int64_t n, float v[3]) {
    for (int i = 0; i < 3; ++i) v[i] = argument[3 * n + i];
  });
  B.cycle();
  // folds correct z as a whole
  const UnturnedResult result = B.result();
  if (folded) {
    cuda::for_each(count / 3, [=] __device__(int64_t n) { result.at(n, preconditioned + 3 * n); });
    folds.end(preconditioned);
  }
  PcgScalars* of = pcg.data();
  ordered_sum(
      count / 3, sums.data(),
      [=] __device__(int64_t n, Sums<1> & sum) {
        float v[3];
        if (folded)
          for (int i = 0; i < 3; ++i) v[i] = preconditioned[3 * n + i];
        else
          result.at(n, v);
        for (int i = 0; i < 3; ++i) {
          preconditioned[3 * n + i] = v[i];
          sum.value[0] += double(residual[3 * n + i]) * double(v[i]);
        }
      },
      [=] __device__(const Sums<1>& sum) { of->turn(sum.value[0]); });
}

/// z = B r and p = z + beta p, which dependent nodes follow; z is 0 there, as r is.
void DeviceNewton::Impl::find_direction() {
  precondition();
  const float* preconditioned = z.data();
  float* direction = p.data();
  const PcgScalars* of = pcg.data();
  cuda::for_each(count, [=] __device__(int64_t k) {
    const float beta = float(of->beta);
    direction[k] = beta == 0 ? preconditioned[k] : preconditioned[k] + beta * direction[k];
  });
  potential.held().fill(direction);
}

/// A p and p . A p.
void DeviceNewton::Impl::find_curvature() {
  potential.hessian_product(p.data(), Ap.data());
  const float *direction = p.data(), *product = Ap.data();
  PcgScalars* of = pcg.data();
  ordered_sum(
      count, sums.data(),
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
  const Signal::Raise raise = passed.raise();
  ordered_sum(
      count, sums.data(),
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

PassKind DeviceNewton::Impl::pass_kind() const {
  DeviceContact* contact = potential.contact();
  const DevicePreconditioner& B = quasi.preconditioner();
  return {contact && contact->is_stiff(), B.has_added(), potential.impl().rate, B.result().scale};
}

/// Starts an iteration of PCG: as one graph, whose launches folds would change.
void DeviceNewton::Impl::iterate() {
  const auto launch_all = [&] {
    find_direction();
    find_curvature();
    advance();
  };
  passed.expect();
  if (!folds.empty()) return launch_all();
  if (const PassKind kind = pass_kind(); kind != recorded) {
    pass.forget();
    recorded = kind;
  }
  pass.run(launch_all);
}

double DeviceNewton::Impl::begin(PotentialValue& value) {
  potential.start_evaluation<double>(quasi.u(), gradient.data());
  measure(gradient);
  signal.wait();
  value = potential.value();
  return std::sqrt(numbers[0].square);
}

void DeviceNewton::Impl::linearise(TangentKind kind, const PotentialValue& value) {
  watch.looks() ? folds.find(quasi.u()) : folds.clear();
  potential.linearise(quasi.u(), kind, value.contact != 0);
  quasi.preconditioner().take_contact();
  folds.assemble();
}

/// The PCG of core/pcg.hpp; the host waits once an iteration, for the residual.
LinearResult DeviceNewton::Impl::run_pcg(double unit, double eta, int most,
                                         const PcgScalars& scalars,
                                         const Interrupted& interrupted) {
  start_pcg(unit, scalars);
  signal.wait();
  const double start = std::sqrt(numbers[0].square);
  double residual = start > 0 ? 1 : 0;
  int iterations = 0;
  numbers[0].pcg = {};
  while (residual > eta && iterations < most && !numbers[0].pcg.ended && !interrupted()) {
    iterate();
    passed.wait();
    if (numbers[0].pcg.alpha == 0) break;
    residual = std::sqrt(numbers[0].square) / start;
    ++iterations;
  }
  const PcgScalars end = numbers[0].pcg;
  scale_step(unit);
  return {iterations, end};
}

void DeviceNewton::Impl::scale_step(double unit) {
  float* step = x.data();
  cuda::for_each(count, [=] __device__(int64_t k) { step[k] *= float(unit); });
}

double DeviceNewton::Impl::slope() {
  measure(gradient);
  signal.wait();
  return trial.slope_start = numbers[0].slope;
}

void DeviceNewton::Impl::move(double share, bool is_first) {
  const double* from = quasi.u();
  const float* step = x.data();
  double* to = trial_u.data();
  cuda::for_each(count, [=] __device__(int64_t k) { to[k] = from[k] + share * double(step[k]); });
  potential.held().follow(to);
  trial.share = share;
  is_cut = is_first && potential.contact();
  if (!is_cut) return;
  potential.contact()->cut_step(quasi.u(), to);
  potential.held().follow(to);
}

void DeviceNewton::Impl::start_trial() {
  potential.start_evaluation<double>(trial_u.data(), trial_gradient.data());
  measure(trial_gradient);
}

TrialNumbers DeviceNewton::Impl::wait() {
  signal.wait();
  if (is_cut) trial.share = potential.contact()->share();
  trial.value = potential.value();
  trial.slope_end = trial.share * numbers[0].slope;
  return trial;
}

double DeviceNewton::Impl::accept() {
  check(cudaMemcpyAsync(quasi.u(), trial_u.data(), size_t(count) * sizeof(double),
                        cudaMemcpyDeviceToDevice, cudaStreamPerThread));
  std::swap(gradient, trial_gradient);
  return std::sqrt(numbers[0].square);
}

DeviceNewton::DeviceNewton(DeviceQuasi& quasi) : impl_(std::make_unique<Impl>(quasi)) {}

DeviceNewton::~DeviceNewton() = default;

IterationResult DeviceNewton::solve(double target, int max_outer, int max_inner,
                                    const Interrupted& interrupted) {
  const IterationResult result =
      newton_loop(*impl_, impl_->region, target, max_outer, max_inner, interrupted);
  impl_->folds.clear();
  return result;
}

/// g = -M/T^2 y by free nodes, so that the Newton step at it is S y.
void DeviceNewton::Impl::set_inertial_gradient(const double* y) {
  const double* inertia = potential.inertia();
  double* const to = gradient.data();
  cuda::for_each(count, [=] __device__(int64_t k) { to[k] = -inertia[k / 3] * y[k]; });
  potential.held().fold(to);
}

void DeviceNewton::Impl::take_step(double* y) {
  const float* step = x.data();
  cuda::for_each(count, [=] __device__(int64_t k) { y[k] = double(step[k]); });
}

void DeviceNewton::filter(double interval, double* y) {
  Impl& s = *impl_;
  const StepScheme scheme(TimeScheme::kEuler, interval, 1);
  s.potential.set_scheme(scheme);
  s.quasi.preconditioner().update_inertia(scheme);
  s.potential.linearise(s.quasi.u(), TangentKind::kProjected, s.potential.value().contact != 0);
  s.quasi.preconditioner().take_contact();
  s.set_inertial_gradient(y);
  s.measure(s.gradient);
  s.signal.wait();
  const double size = std::sqrt(s.numbers[0].square);
  if (!(size > 0)) return;
  // scaled to 1, so that float holds it
  const double unit = size / std::sqrt(double(s.count));
  s.run_pcg(unit, kFilterTolerance, kFilterIterations, {}, [] { return false; });
  s.take_step(y);
}

size_t DeviceNewton::bytes(const DevicePotential& potential) {
  return 3 * size_t(potential.nodes()) * (kDoubles * sizeof(double) + kFloats * sizeof(float)) +
         sizeof(SumScratch<Sums<1>>) + sizeof(SumScratch<Sums<2>>) + sizeof(PcgScalars) +
         potential.tangent_bytes();
}

}  // namespace elastogen::cuda
