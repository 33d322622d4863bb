// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/integrators/equilibrium.hpp"

#include <algorithm>
#include <limits>

namespace elastogen::fem {
namespace {

constexpr int kFirstSteps = 3;     // on frozen potentials, before the true forces
constexpr int kMostFallbacks = 8;  // before a step is left as a draft
constexpr int kMostHalvings = 12;  // of a step on the true forces
constexpr int kPatience = 15;      // Newton steps in which the forces have to fall tenfold

NewtonStop as_newton(RootStop stop) {
  switch (stop) {
    case RootStop::kConverged:
      return NewtonStop::kConverged;
    case RootStop::kRoundOff:
      return NewtonStop::kRoundOff;
    case RootStop::kIterations:
      return NewtonStop::kIterations;
    case RootStop::kLineSearch:
      return NewtonStop::kLineSearch;
    case RootStop::kSingular:
      return NewtonStop::kIndefinite;
    default:
      return NewtonStop::kNotFinite;
  }
}

/// A Newton step on the potential frozen at u. @return its iterations, 0 or 1
int frozen_step(FemPotential& terms, double tolerance, double* u) {
  PlasticBody& body = terms.plastic->body();
  body.freeze({u, body.mesh().rest.rows(), 3});
  const NewtonResult result =
      terms.potential.minimise({.tolerance = tolerance, .max_iterations = 1}, u);
  body.thaw();
  return result.iterations;
}

}  // namespace

Equilibrium find_equilibrium(FemPotential& terms, const NewtonOptions& options, double* u) {
  // with a potential: its minimum
  if (!terms.plastic || terms.plastic->body().has_energy()) {
    const NewtonResult newton = terms.potential.minimise(options, u);
    return {newton.stop, newton.iterations, 0, newton.noise};
  }
  // without one: frozen potentials bring u near
  terms.plastic->body().thaw();
  Equilibrium result;
  for (int k = 0; k < kFirstSteps; ++k)
    result.iterations += frozen_step(terms, options.tolerance, u);
  // Newton's method on the true forces, and a frozen step where it fails or is slow
  double before = std::numeric_limits<double>::infinity();
  while (true) {
    const int left = std::max(0, options.max_iterations - result.iterations);
    const RootResult root = terms.potential.find_root({.tolerance = options.tolerance,
                                                       .max_iterations = std::min(left, kPatience),
                                                       .max_halvings = kMostHalvings},
                                                      u);
    result.iterations += root.iterations;
    result.stop = as_newton(root.stop);
    result.noise = root.noise;
    const bool runs = root.stop == RootStop::kIterations, falls = root.residual < 0.1 * before;
    const bool failed = root.stop == RootStop::kLineSearch || root.stop == RootStop::kSingular;
    before = root.residual;
    if (!failed && (!runs || left <= kPatience)) return result;
    if (runs && falls) continue;
    if (result.fallbacks == kMostFallbacks) return result;
    ++result.fallbacks;
    result.iterations += frozen_step(terms, options.tolerance, u);
  }
}

}  // namespace elastogen::fem
