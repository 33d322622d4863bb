// SPDX-License-Identifier: Apache-2.0
// The quasi mode on either machine: L-BFGS(5) whose first matrix is one pass of the preconditioner;
// no Hessian is formed. Liu, Bouaziz, Kavan 2017 with multigrid in place of a factorised matrix.

#pragma once

#include "network/step/iteration.hpp"

#include <limits>

namespace elastogen {

/// A machine that holds the vectors of L-BFGS with gradients in Work::Real: quasi_solver.cpp on the
/// host, quasi_solver.cu on a card.
template <class Work>
concept QuasiWork = DescentWork<Work> &&
    requires(Work& work, PotentialValue& value, const PotentialValue& at_u) {
  typename Work::Real;
  { work.begin(value) } -> std::same_as<double>;      ///< value at u, |gradient|
  { work.find_step(at_u) } -> std::same_as<bool>;     ///< false: known to lead uphill
  { work.accept() } -> std::same_as<double>;          ///< the trial becomes u; |gradient|
  { work.pair_count() } -> std::convertible_to<int>;  ///< of the history
  work.clear();                                       ///< forgets the history
  { work.terms() } -> std::convertible_to<const PotentialTerms&>;
};

/// Iterations within which the gradient has to halve while it is in float.
inline constexpr int kPatience = 25;

/// Improves u until |grad Phi|_2 <= target [N], at most max_outer iterations. In float it also ends
/// where kPatience iterations did not halve the gradient: the rest is for double.
/// @return outer counts iterations, inner evaluations.
template <QuasiWork Work>
IterationResult quasi_loop(Work& work, double target, int max_outer,
                           const Interrupted& interrupted) {
  using Real = typename Work::Real;
  constexpr bool kFloat = sizeof(Real) == 4;
  IterationResult result{.inner = 1, .float64 = !kFloat};
  PotentialValue value;
  double residual = work.begin(value), half = std::numeric_limits<double>::max();
  int halved_at = 0;
  while (true) {
    // float has no digits left where the gradient stops to halve
    if (residual < half) half = residual / 2, halved_at = result.outer;
    const bool stalled = kFloat && result.outer - halved_at > kPatience;
    result.converged = residual <= target;
    if (result.converged || stalled || result.outer == max_outer || interrupted()) return result;

    const double noise = work.terms().noise(value, std::numeric_limits<Real>::epsilon());
    if (!work.find_step(value) || !descend(work, noise, value, result.inner)) {
      // the pairs may be out of date; without them the step is that of the first matrix alone
      if (work.pair_count() == 0) return result;
      work.clear();
      continue;
    }
    residual = work.accept();
    ++result.outer;
  }
}

}  // namespace elastogen
