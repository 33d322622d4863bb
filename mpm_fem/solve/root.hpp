// SPDX-License-Identifier: Apache-2.0
// Newton's method for a root r(x) = 0 whose Jacobian need not be symmetric. As there is no energy,
// the merit |r|^2/2 judges a step: it must lower |r| as an inexact Newton step should (Eisenstat,
// Walker 1994).

#pragma once

#include <cstdint>
#include <functional>
#include <string_view>

namespace elastogen::fem {

/// The function whose root is sought. x includes held unknowns; their residual and step are 0.
struct RootFunction {
  int64_t unknowns = 0;
  /// Writes r(x).
  std::function<void(const double* x, double* r)> residual;
  /// Writes step = -J^-1 r, the linear system solved to |J step + r| <= tolerance |r|; false if it
  /// cannot be solved.
  std::function<bool(const double* x, const double* r, double tolerance, double* step)> step;
  /// Largest share, at most 1, of the path from x to end on which r stays finite; empty: 1.
  std::function<double(const double* x, const double* end)> longest_step;
  /// Bound on the rounding error of r at x, 2-norm.
  std::function<double(const double* x)> noise;
};

/// Why the search ended. kRoundOff: above the tolerance, but within the rounding error of r, and no
/// step made it smaller. kSingular: no step could be found. kLineSearch: no share of a step lowered
/// |r|.
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
  double noise = 0;     ///< bound on its rounding error; 0 if not needed
};

/// Moves x to a root or, if it reaches none, to the smallest |r| that it finds.
RootResult solve_root(const RootFunction& function, const RootOptions& options, double* x);

}  // namespace elastogen::fem
