// SPDX-License-Identifier: Apache-2.0
// Which iteration improves u in a step.
#include "network/step/solver_impl.hpp"

#include <algorithm>

namespace elastogen {
namespace {

constexpr double kNewtonCourant = 100;   // auto: newton from here on,
constexpr double kNewtonPoisson = 0.47;  // or here,
constexpr double kCheap = 40;            // cost of a step that auto does not try to better

}  // namespace

bool Solver::Impl::is_stiff() const {
  double poisson = 0;
  for (const Material& m : scene.materials) poisson = std::max(poisson, m.poisson);
  return courant > kNewtonCourant || poisson > kNewtonPoisson;
}

IterationResult Solver::Impl::quasi(double target, double precise_below) {
  return work->quasi(target, options.max_outer, precise_below, [&] { return polled(); });
}

IterationResult Solver::Impl::newton(double target) {
  return work->newton(target, std::max(1, options.max_outer), options.max_inner,
                      [&] { return polled(); });
}

/// By the present mode. Quasi is in float while that can reach the target, and where it then did
/// not, in double.
IterationResult Solver::Impl::iterate(double target) {
  if (mode == SolverMode::kPaper) return work->paper(options.interrupted);
  if (mode == SolverMode::kNewton) return newton(target);
  const double float_serves = options.skip ? 3 * float_floor(scene) : kAlways;
  const bool float_reaches = in_float && float_serves < tolerance;
  const IterationResult result = quasi(target, float_reaches ? 0 : float_serves * force);
  if (result.converged || !float_reaches) return result;
  return sum(result, quasi(target, kAlways));
}

/// What a step cost, in passes of the preconditioner: one of quasi comes with an evaluation, one of
/// newton with a product, and a Newton step with Hessian and evaluation.
double Solver::Impl::cost(const IterationResult& r) const {
  if (!r.converged) return kFailed;
  return mode == SolverMode::kNewton ? 1.3 * r.inner + 3 * r.outer : 2 * r.inner;
}

/// Iterates and remembers what the kind of start of this step cost.
IterationResult Solver::Impl::iterate_and_learn(double target, int64_t step) {
  const IterationResult result = iterate(target);
  if (extrapolates && (result.converged || !stopped()))
    starts[size_t(mode)].take(start_kind, step, cost(result));
  return result;
}

/// auto: quasi while that is cheap, else the cheaper of both; where one does not converge the other
/// is tried. Where Phi is not convex (`bounded`) quasi gets nowhere, and newton stays.
IterationResult Solver::Impl::choose(double target, int64_t step) {
  // a step that only tries the dearer kind of start says nothing of the mode
  const bool tries_start = extrapolates && start_kind != starts[size_t(mode)].better();
  IterationResult result = iterate_and_learn(target, step);
  if (options.mode != SolverMode::kAuto || is_stiff() || (tries_start && result.converged))
    return result;

  // the other mode, where this one failed or is dear and the other may be cheaper
  const SolverMode other = mode == SolverMode::kNewton ? SolverMode::kQuasi : SolverMode::kNewton;
  last_cost[int(mode)] = cost(result);
  last_step[int(mode)] = step;
  const bool lost = last_cost[int(other)] > kMuchDearer * last_cost[int(mode)];
  const bool stale = step - last_step[int(other)] >= (lost ? kLateRetry : kRetry);
  const bool dear = last_cost[int(mode)] > kCheap || mode == SolverMode::kNewton;
  const bool better = last_cost[int(other)] < last_cost[int(mode)];
  if (!result.converged) {
    if (stopped()) return result;
    mode = other;
    result = sum(result, iterate(target));
  } else if (dear && !result.bounded && (stale || better)) {
    mode = other;
  }
  return result;
}

}  // namespace elastogen
