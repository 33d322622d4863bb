// SPDX-License-Identifier: Apache-2.0
#include "network/newton_solver.hpp"

#include "core/line_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace elastogen {

namespace {

constexpr int kCreep = 20;        // Newton steps
constexpr int kMostFailures = 4;  // to shorten a step by 2^12 and the region after it by 2^6

}  // namespace

double forcing_term(double residual, double before, double last, double target) {
  double eta = 0.1;
  if (before > 0) {
    eta = 0.9 * (residual / before) * (residual / before);
    if (0.9 * last * last > 0.1) eta = std::max(eta, 0.9 * last * last);
    eta = std::min(eta, 0.1);
  }
  return std::max(eta, 0.5 * target / residual);
}

void NewtonRegion::begin() {
  tangent_ = bounded_ ? TangentKind::kTrue : TangentKind::kProjected;
  region_ = {};
  steps_ = failures_ = 0;
  bounded_ = false;
}

bool NewtonRegion::take_step(const PcgScalars& end, double unit, const StepTaken& step) {
  const bool moved = step.share > 0;
  failures_ = moved ? 0 : failures_ + 1;
  if (tangent_ == TangentKind::kTrue) {
    region_.update(end, unit, step);
    bounded_ = bounded_ || end.at_edge || step.halved;
  } else if (++steps_ == kCreep || !moved) {
    tangent_ = TangentKind::kTrue;
  }
  return moved || (failures_ <= kMostFailures && -step.slope > step.noise);
}

NewtonSolver::NewtonSolver(IncrementalPotential& potential)
    : potential_(potential),
      size_(3 * potential.scene().grid.node_count()),
      trial_u_(size_t(size_)),
      gradient_(size_t(size_)),
      trial_gradient_(size_t(size_)),
      right_(size_t(size_)),
      step_(size_t(size_)),
      work_(size_) {}

/// Moves u along step_ where Phi falls; taken_ says how far, gradient_ and value follow.
void NewtonSolver::line_search(double* u, PotentialValue& value) {
  const auto slope_of = [&](const std::vector<double>& g) {
    return ordered_sum(size_, [&](int64_t begin, int64_t end) {
      double sum = 0;
      for (int64_t k = begin; k < end; ++k) sum += g[size_t(k)] * double(step_[size_t(k)]);
      return sum;
    });
  };
  const auto move = [&](double a) {
    for_each(size_, [&](int64_t k) { trial_u_[size_t(k)] = u[k] + a * double(step_[size_t(k)]); });
  };
  const double slope = slope_of(gradient_);
  const double noise = potential_.noise(value, std::numeric_limits<double>::epsilon());
  taken_ = {slope, noise};
  if (!(slope < 0)) return;
  PotentialValue there;
  const auto found = backtrack([&](double a, int halvings) {
    move(a);
    if (halvings == 0 && potential_.contact().exists()) {
      a = potential_.contact().longest_step(u, trial_u_.data());
      if (a < 1) move(a);
    }
    there = potential_.evaluate<double>(trial_u_.data(), trial_gradient_.data());
    return LineTrial{.share = a,
                     .difference = there.total() - value.total(),
                     .slope_start = slope,
                     .slope_end = a * slope_of(trial_gradient_),
                     .noise = noise};
  });
  if (!found) return;
  std::copy(trial_u_.begin(), trial_u_.end(), u);
  gradient_.swap(trial_gradient_);
  value = there;
  taken_ = {slope, noise, found->change(), found->share, found->halvings > 0};
}

template <class P>
IterationResult NewtonSolver::solve(double* u, double target, int max_outer, int max_inner,
                                    Preconditioner<P>& preconditioner,
                                    const std::function<bool()>& interrupted) {
  IterationResult result;
  PotentialValue value = potential_.evaluate<double>(u, gradient_.data());
  double before = 0, eta = 0.1;
  region_.begin();
  while (true) {
    const double residual = norm(gradient_.data(), size_);
    result.converged = residual <= target;
    result.bounded = region_.bounded();
    if (result.converged || result.outer >= region_.most_steps(max_outer) || interrupted())
      return result;
    potential_.linearise(u, region_.tangent());
    preconditioner.update_contact();
    eta = forcing_term(residual, before, eta, target);
    before = residual;

    // the right-hand side is scaled to 1, so that float holds it whatever the units of the scene
    const double unit = residual / std::sqrt(double(size_));
    for_each(size_, [&](int64_t k) { right_[size_t(k)] = float(-gradient_[size_t(k)] / unit); });
    const PcgResult inner = pcg(
        right_.data(), step_.data(), size_, eta, max_inner, work_,
        [&](const float* p, float* Ap) { potential_.hessian_product(p, Ap); },
        [&](const float* r, float* z) { preconditioner.apply(r, z); }, interrupted,
        region_.scalars(unit));
    result.inner += std::max(inner.iterations, 1);
    for_each(size_, [&](int64_t k) { step_[size_t(k)] *= float(unit); });
    ++result.outer;
    line_search(u, value);
    if (!region_.take_step(inner.end, unit, taken_)) return result;
  }
}

#define ELASTOGEN_INSTANTIATE(P) \
  template IterationResult NewtonSolver::solve(double*, double, int, int, Preconditioner<P>&, \
                                               const std::function<bool()>&);
ELASTOGEN_INSTANTIATE(float)
ELASTOGEN_INSTANTIATE(double)
#undef ELASTOGEN_INSTANTIATE

}  // namespace elastogen
