// SPDX-License-Identifier: Apache-2.0
// What the iterations over the incremental potential share, on the host and on a card: how they
// end, and the line search.

#pragma once

#include "core/line_search.hpp"
#include "network/potential/potential_terms.hpp"

#include <functional>
#include <optional>

namespace elastogen {

/// Polled once an iteration; true gives the iteration up.
using Interrupted = std::function<bool()>;

/// How an iteration over the potential ended.
struct IterationResult {
  bool converged = false;  ///< |gradient| <= target in the precision of the iteration
  int outer = 0, inner = 0;
  bool bounded = false;  ///< a trust region has cut steps: Phi is not convex there
  bool float64 = true;   ///< gradients were in double at the end
};

/// Two iterations, b after a.
inline IterationResult sum(const IterationResult& a, const IterationResult& b) {
  return {b.converged, a.outer + b.outer, a.inner + b.inner, a.bounded || b.bounded, b.float64};
}

/// What is measured at a trial of a line search.
struct TrialNumbers {
  PotentialValue value;
  double share = 1;        ///< of the step that was gone
  double slope_start = 0;  ///< Phi' at the start, along the whole step
  double slope_end = 0;    ///< share times Phi' at the trial, along the whole step
};

/// A machine on which line searches run: it holds u, a step d from it and a trial u + share d.
/// start_trial() need not wait for its kernels; wait() does.
template <class Work>
concept DescentWork = requires(Work& work, double share, bool is_first) {
  work.move(share, is_first);  ///< makes the trial; the first one is cut where colliders are met
  work.start_trial();          ///< evaluates value and gradient there
  { work.wait() } -> std::same_as<TrialNumbers>;
};

/// The line search of all iterations: halves the step until Phi falls (core/line_search.hpp).
/// @param value  that at u; becomes that at the accepted trial.
/// @param evaluations  is raised by one for each trial.
template <DescentWork Work>
std::optional<LineTrial> descend(Work& work, double noise, PotentialValue& value,
                                 int& evaluations) {
  PotentialValue there;
  const auto found = backtrack([&](double share, int halvings) {
    work.move(share, halvings == 0);
    work.start_trial();
    const TrialNumbers trial = work.wait();
    ++evaluations;
    there = trial.value;
    return LineTrial{.share = trial.share,
                     .difference = there.total() - value.total(),
                     .slope_start = trial.slope_start,
                     .slope_end = trial.slope_end,
                     .noise = noise};
  });
  if (found) value = there;
  return found;
}

}  // namespace elastogen
