// SPDX-License-Identifier: Apache-2.0
// Newton's method for a root r(x) = 0 whose Jacobian need not be symmetric, so that no energy can
// judge a step: the merit |r|^2/2 does. A step is taken where it lowers |r| as an inexact Newton
// step should (Eisenstat, Walker 1994).

#pragma once

#include <cstdint>
#include <functional>
#include <string_view>

namespace elastogen::fem {

/// What has the root. Held unknowns are among the x; there residual and step are 0.
struct RootFunction {
  int64_t unknowns = 0;
  /// Writes r(x).
  std::function<void(const double* x, double* r)> residual;
  /// Writes step = -J^-1 r, the linear system solved to |J step + r| <= tolerance |r|; false where
  /// it cannot be solved.
  std::function<bool(const double* x, const double* r, double tolerance, double* step)> step;
  /// Largest share, at most 1, of the way from x to end on which r stays finite; empty: 1.
  std::function<double(const double* x, const double* end)> longest_step;
  /// Bound on the rounding error of r at x, 2-norm.
  std::function<double(const double* x)> noise;
};

/// Why it ended. kRoundOff: above the tolerance, but within the rounding error of r, and no step
/// made it smaller. kSingular: no step could be found. kLineSearch: none of its shares lowered |r|.
enum class RootStop : uint8_t {
  kConverged,
  kRoundOff,
  kIterations,
  kLineSearch,
  kSingular,
  kNotFinite
};

/// "converged", "round-off", ...
std::string_view stop_name(RootStop stop);

struct RootOptions {
  double tolerance = 0;  ///< of |r|, in its unit
  int max_iterations = 100;
  int max_halvings = 40;        ///< of a step that does not lower |r|
  double loosest_solve = 1e-2;  ///< tolerance of the linear systems far from the root
};

struct RootResult {
  RootStop stop = RootStop::kConverged;
  int iterations = 0;
  int evaluations = 0;  ///< of r
  double residual = 0;  ///< |r| at the end
  double noise = 0;     ///< bound on its rounding error; 0 where nobody had to ask
};

/// Moves x to a root; where there is none in reach, to the smallest |r| on its way.
RootResult solve_root(const RootFunction& function, const RootOptions& options, double* x);

}  // namespace elastogen::fem
