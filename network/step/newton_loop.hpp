// SPDX-License-Identifier: Apache-2.0
// The newton mode on either machine: the Hessian as it is in a trust region, PCG with V-cycle and
// encoder to an Eisenstat-Walker forcing term, line search on the true potential. Gradients are
// float64, corrections float. Where a surface folds Phi has saddles, along which a projected Hessian
// would creep.

#pragma once

#include "network/step/iteration.hpp"
#include "network/step/newton_region.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace elastogen {

/// How PCG ended.
struct LinearResult {
  int iterations = 0;
  PcgScalars end = {};
};

/// A machine that holds the vectors of Newton steps and of PCG: newton_solver.cpp on the host,
/// newton_solver.cu on a card.
template <class Work>
concept NewtonWork = DescentWork<Work> &&
    requires(Work& work, PotentialValue& value, TangentKind kind, double unit, double eta, int most,
             const PcgScalars& scalars, const Interrupted& interrupted) {
  { work.begin(value) } -> std::same_as<double>;  ///< value at u, |gradient|
  work.linearise(kind, value);                    ///< freezes the Hessian at u
  /// Solves H d = -g; residuals are in units of `unit`. d [m] is the step of the line search.
  { work.solve(unit, eta, most, scalars, interrupted) } -> std::same_as<LinearResult>;
  { work.slope() } -> std::same_as<double>;   ///< g . d
  { work.accept() } -> std::same_as<double>;  ///< the trial becomes u; |gradient|
  { work.size() } -> std::same_as<int64_t>;   ///< numbers of a vector
  { work.terms() } -> std::convertible_to<const PotentialTerms&>;
};

/// Moves u along the step where Phi falls, and says how far; the residual follows.
template <NewtonWork Work>
StepTaken newton_descent(Work& work, PotentialValue& value, double& residual) {
  const double slope = work.slope();
  const double noise = work.terms().noise(value, std::numeric_limits<double>::epsilon());
  if (!(slope < 0)) return {slope, noise};
  int evaluations = 0;
  const auto found = descend(work, noise, value, evaluations);
  if (!found) return {slope, noise};
  residual = work.accept();
  return {slope, noise, found->change(), found->share, found->halvings > 0};
}

/// Improves u until |grad Phi|_2 <= target [N], at most max_outer Newton steps of max_inner PCG
/// iterations each.
/// @param region  kept from one iteration to the next.
/// @return outer counts Newton steps, inner PCG iterations.
template <NewtonWork Work>
IterationResult newton_loop(Work& work, NewtonRegion& region, double target, int max_outer,
                            int max_inner, const Interrupted& interrupted) {
  IterationResult result;
  PotentialValue value;
  double residual = work.begin(value), before = 0, eta = 0.1;
  region.begin();
  while (true) {
    result.converged = residual <= target;
    result.bounded = region.bounded();
    if (result.converged || result.outer >= max_outer || interrupted()) return result;

    // the linear system, as far as it pays
    work.linearise(TangentKind::kTrue, value);
    eta = forcing_term(residual, before, eta, target);
    before = residual;
    // its right-hand side is scaled to 1, so that float holds it whatever the units of the scene
    const double unit = residual / std::sqrt(double(work.size()));
    const LinearResult inner = work.solve(unit, eta, max_inner, region.scalars(unit), interrupted);
    result.inner += std::max(inner.iterations, 1);
    ++result.outer;

    // the step, and what it says of the quadratic model
    const StepTaken taken = newton_descent(work, value, residual);
    if (!region.take_step(inner.end, unit, taken)) return result;
  }
}

}  // namespace elastogen
