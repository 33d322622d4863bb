// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/integrators/fixed_point_mpm.hpp"

#include "core/stopwatch.hpp"

#include <cmath>

namespace elastogen::mpm {

template <int d>
FixedPointMpm<d>::FixedPointMpm(const MpmScene& scene, const FixedPointOptions& options)
    : options_(options),
      scene_(scene),
      potential_(scene),
      pass_(potential_, options.max_iterations) {}

template <int d>
double FixedPointMpm<d>::true_residual(const std::vector<double>& y) {
  r_.resize(y.size());
  potential_.residual(y.data(), r_.data());
  return norm(r_.data(), int64_t(r_.size())) / potential_.reference();
}

template <int d>
MpmStepReport FixedPointMpm<d>::step(double time, Particles& p) {
  const Stopwatch watch;
  MpmStepReport report;
  // the published loop starts without motion, the other one from the prediction
  potential_.begin(p, time, scene_.dt);
  std::vector<double> y(size_t(potential_.unknowns()));
  if (!options_.published) potential_.predict(y.data());
  const fem::NewtonOptions minimum{.tolerance = options_.tolerance * potential_.reference(),
                                   .max_iterations = options_.max_newton};
  const int64_t before = pass_.iterations();
  report.residual = true_residual(y);
  // passes until the true residual is within the tolerance
  while (report.passes < options_.passes && std::isfinite(report.residual) &&
         (options_.published || report.residual > options_.tolerance)) {
    report.outer += pass_.take(options_.published, minimum, y.data()).iterations;
    report.residual = true_residual(y);
    ++report.passes;
  }
  report.inner = int(pass_.iterations() - before);
  report.converged = report.residual <= options_.tolerance;
  report.stop = report.converged ? fem::RootStop::kConverged : fem::RootStop::kIterations;
  report.finite = std::isfinite(report.residual);
  report.float64 = true;
  report.time = time + scene_.dt;
  // particles change only if the result is finite
  if (report.finite) {
    potential_.commit(y.data(), p);
    potential_.transfer(p);
  }
  report.ms = watch.milliseconds();
  return report;
}

template class FixedPointMpm<2>;
template class FixedPointMpm<3>;

}  // namespace elastogen::mpm
