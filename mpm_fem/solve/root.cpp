// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/solve/root.hpp"

#include "core/line_search.hpp"
#include "core/reduce.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace elastogen::fem {
namespace {

class RootSearch {
 public:
  RootSearch(const RootFunction& function, const RootOptions& options, double* x)
      : function_(function),
        options_(options),
        x_(x),
        size_(function.unknowns),
        trial_(size_t(size_)),
        r_(trial_),
        trial_r_(trial_),
        step_(trial_) {}

  RootResult run();

 private:
  double evaluate(const double* x, std::vector<double>& r) {
    ++result_.evaluations;
    function_.residual(x, r.data());
    return norm(r.data(), size_);
  }
  double solve_tolerance() const;
  void move_trial(double share);
  bool shorten_step(double tolerance);
  RootResult end(RootStop stop);

  const RootFunction& function_;
  const RootOptions& options_;
  double* x_;
  int64_t size_;
  std::vector<double> trial_, r_, trial_r_, step_;
  RootResult result_;
  double first_ = 0;  // |r| at the start
};

/// Tolerance of a linear solve: for superlinear convergence, but not beyond what is asked for.
double RootSearch::solve_tolerance() const {
  const double loose = options_.loosest_solve;
  const double eta = std::min(loose, result_.residual / first_);
  return std::max({eta, std::min(loose, 0.1 * options_.tolerance / result_.residual), 1e-12});
}

void RootSearch::move_trial(double share) {
  for_each(size_, [&](int64_t k) { trial_[size_t(k)] = x_[k] + share * step_[size_t(k)]; });
}

/// Shortens step_ until |r| falls by enough: the merit's slope along the step is at most
/// -(1 - tolerance) |r|^2. False: it never did.
bool RootSearch::shorten_step(double tolerance) {
  double size = 0;
  const auto trial = [&](double share, int halvings) {
    move_trial(share);
    if (halvings == 0 && function_.longest_step) {
      share = function_.longest_step(x_, trial_.data());
      move_trial(share);
    }
    size = evaluate(trial_.data(), trial_r_);
    // no noise: |r| is compared as it is
    return LineTrial{.share = share,
                     .difference = size - result_.residual,
                     .slope_start = -(1 - tolerance) * result_.residual,
                     .noise = -std::numeric_limits<double>::infinity()};
  };
  if (!backtrack(trial, options_.max_halvings)) return false;
  std::copy(trial_.begin(), trial_.end(), x_);
  r_.swap(trial_r_);
  result_.residual = size;
  return true;
}

/// Ends with a stop, or with kRoundOff if rounding explains it.
RootResult RootSearch::end(RootStop stop) {
  result_.stop = stop;
  if (stop == RootStop::kConverged || stop == RootStop::kNotFinite) return result_;
  result_.noise = function_.noise(x_);
  if (result_.residual <= result_.noise) result_.stop = RootStop::kRoundOff;
  return result_;
}

RootResult RootSearch::run() {
  first_ = result_.residual = evaluate(x_, r_);
  while (true) {
    if (!std::isfinite(result_.residual)) return end(RootStop::kNotFinite);
    if (result_.residual <= options_.tolerance) return end(RootStop::kConverged);
    if (result_.iterations == options_.max_iterations) return end(RootStop::kIterations);
    const double before = result_.residual, tolerance = solve_tolerance();
    if (!function_.step(x_, r_.data(), tolerance, step_.data())) return end(RootStop::kSingular);
    if (!shorten_step(tolerance)) return end(RootStop::kLineSearch);
    ++result_.iterations;
    // after a step that gains little, rounding may hide any further gain
    const bool stalled = result_.residual > options_.tolerance && result_.residual > before / 2;
    if (stalled && result_.residual <= function_.noise(x_)) return end(RootStop::kRoundOff);
  }
}

}  // namespace

std::string_view stop_name(RootStop stop) {
  constexpr std::string_view kNames[] = {"converged",   "round-off", "iterations",
                                         "line search", "singular",  "not finite"};
  return kNames[int(stop)];
}

RootResult solve_root(const RootFunction& function, const RootOptions& options, double* x) {
  return RootSearch(function, options, x).run();
}

}  // namespace elastogen::fem
