// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/solve/newton.hpp"

#include "core/line_search.hpp"
#include "core/reduce.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen::fem {
namespace {

constexpr int kMaxHalvings = 40;
constexpr double kLooseSolve = 1e-2;  // of the linear systems far from the minimum

class Newton {
 public:
  Newton(const NewtonFunction& function, const NewtonOptions& options, double* x)
      : function_(function),
        options_(options),
        x_(x),
        size_(function.unknowns),
        trial_(size_t(size_)),
        gradient_(trial_),
        trial_gradient_(trial_),
        step_(trial_) {}

  NewtonResult run();

 private:
  NewtonValue evaluate(const double* x, std::vector<double>& gradient) {
    ++result_.evaluations;
    return function_.evaluate(x, gradient.data());
  }
  double solve_tolerance() const;
  double longest_step();
  bool line_search();
  bool advance();
  NewtonResult end(NewtonStop stop);
  NewtonResult end_above_tolerance(NewtonStop stop);

  const NewtonFunction& function_;
  const NewtonOptions& options_;
  double* x_;
  int64_t size_;
  std::vector<double> trial_, gradient_, trial_gradient_, step_;
  NewtonValue value_;
  NewtonResult result_;
  double first_ = 0;  // residual at the start
};

/// Tolerance of a linear solve: for superlinear convergence, but not beyond what is asked for.
double Newton::solve_tolerance() const {
  const double eta = std::min(kLooseSolve, result_.residual / first_);
  return std::max({eta, 0.1 * options_.tolerance / result_.residual, 1e-12});
}

/// The share of step_ that the function allows.
double Newton::longest_step() {
  if (!function_.longest_step) return 1;
  for_each(size_, [&](int64_t k) { trial_[size_t(k)] = x_[k] + step_[size_t(k)]; });
  return function_.longest_step(x_, trial_.data());
}

/// Shortens step_ until the value falls. False: it never did.
bool Newton::line_search() {
  const double slope = dot(gradient_.data(), step_.data(), size_);
  if (!(slope < 0)) return false;
  NewtonValue there;
  const auto trial = [&](double share, int halvings) {
    const double a = halvings == 0 ? longest_step() : share;
    for_each(size_, [&](int64_t k) { trial_[size_t(k)] = x_[k] + a * step_[size_t(k)]; });
    there = evaluate(trial_.data(), trial_gradient_);
    return LineTrial{.share = a,
                     .difference = there.value - value_.value,
                     .slope_start = slope,
                     .slope_end = a * dot(trial_gradient_.data(), step_.data(), size_),
                     .noise = value_.noise + there.noise};
  };
  if (!backtrack(trial, kMaxHalvings)) return false;
  std::copy(trial_.begin(), trial_.end(), x_);
  gradient_.swap(trial_gradient_);
  value_ = there;
  return true;
}

/// Makes one step, exact or projected; if there is none result_.stop says why.
bool Newton::advance() {
  const double tolerance = solve_tolerance();
  result_.stop = NewtonStop::kIndefinite;
  for (const TangentKind kind : {TangentKind::kTrue, TangentKind::kProjected}) {
    if (!function_.step(x_, gradient_.data(), kind, tolerance, step_.data())) continue;
    if (line_search()) {
      ++result_.iterations;
      result_.projected += kind == TangentKind::kProjected;
      return true;
    }
    result_.stop = NewtonStop::kLineSearch;
    if (result_.residual <= function_.gradient_noise(x_)) return false;
  }
  return false;
}

NewtonResult Newton::end(NewtonStop stop) {
  result_.stop = stop;
  result_.value = value_.value;
  return result_;
}

NewtonResult Newton::end_above_tolerance(NewtonStop stop) {
  result_.noise = function_.gradient_noise(x_);
  return end(result_.residual <= result_.noise ? NewtonStop::kRoundOff : stop);
}

NewtonResult Newton::run() {
  value_ = evaluate(x_, gradient_);
  first_ = norm(gradient_.data(), size_);
  result_.residual = first_;
  while (true) {
    if (!std::isfinite(result_.residual) || !std::isfinite(value_.value))
      return end(NewtonStop::kNotFinite);
    if (result_.residual <= options_.tolerance) return end(NewtonStop::kConverged);
    if (result_.iterations == options_.max_iterations)
      return end_above_tolerance(NewtonStop::kIterations);
    if (!advance()) return end_above_tolerance(result_.stop);
    const double before = result_.residual;
    result_.residual = norm(gradient_.data(), size_);
    // after a step that gains little, rounding may hide any further gain
    const bool stalled = result_.residual > options_.tolerance && result_.residual > before / 2;
    if (stalled && result_.residual <= function_.gradient_noise(x_))
      return end_above_tolerance(NewtonStop::kRoundOff);
  }
}

}  // namespace

std::string_view stop_name(NewtonStop stop) {
  constexpr std::string_view kNames[] = {"converged",   "round-off",  "iterations",
                                         "line search", "indefinite", "not finite"};
  return kNames[int(stop)];
}

NewtonResult minimise(const NewtonFunction& function, const NewtonOptions& options, double* x) {
  return Newton(function, options, x).run();
}

}  // namespace elastogen::fem
