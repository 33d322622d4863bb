// SPDX-License-Identifier: Apache-2.0
// Newton's method for a minimum. Each step uses the exact Hessian or, if that is not positive
// definite, the projected one, and a line search by Armijo's rule (core/line_search.hpp).

#pragma once

#include "core/tangent.hpp"

#include <cstdint>
#include <functional>
#include <string_view>

namespace elastogen::fem {

struct NewtonValue {
  double value = 0;
  double noise = 0;  ///< bound on the rounding error of value
};

/// The function that is minimised. x includes held unknowns; their gradient and step are 0.
struct NewtonFunction {
  int64_t unknowns = 0;
  /// Value and gradient at x.
  std::function<NewtonValue(const double* x, double* gradient)> evaluate;
  /// Writes step = -H^-1 gradient, the linear system solved to a relative tolerance; false if H is
  /// not positive definite, as the projected H always should be.
  std::function<bool(const double* x, const double* gradient, TangentKind kind, double tolerance,
                     double* step)>
      step;
  /// Largest share, at most 1, of the path from x to end on which the value stays finite; empty: 1.
  std::function<double(const double* x, const double* end)> longest_step;
  /// Bound on the rounding error of the gradient at x, 2-norm.
  std::function<double(const double* x)> gradient_noise;
};

/// Why Newton's method ended. kRoundOff: above the tolerance, but within the rounding error of the
/// gradient, and no step made it smaller.
enum class NewtonStop : uint8_t {
  kConverged,
  kRoundOff,
  kIterations,
  kLineSearch,
  kIndefinite,
  kNotFinite
};

/// "converged", "round-off", ...
std::string_view stop_name(NewtonStop stop);

struct NewtonOptions {
  double tolerance = 0;  ///< of the 2-norm of the gradient, in its unit
  int max_iterations = 100;
};

struct NewtonResult {
  NewtonStop stop = NewtonStop::kConverged;
  int iterations = 0;
  int projected = 0;    ///< iterations with the projected Hessian
  int evaluations = 0;  ///< of value and gradient
  double residual = 0;  ///< 2-norm of the gradient at the end
  double noise = 0;     ///< bound on its rounding error; 0 if not needed
  double value = 0;
};

/// Moves x to a minimum.
NewtonResult minimise(const NewtonFunction& function, const NewtonOptions& options, double* x);

}  // namespace elastogen::fem
