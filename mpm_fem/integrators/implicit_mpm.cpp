// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/integrators/implicit_mpm.hpp"

#include "core/error.hpp"
#include "core/stopwatch.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen::mpm {

constexpr double kLooseSolve = 0.1;  // of the linear systems far from the root
constexpr int kFewIterations = 60;   // of GMRES, after which factors cost less

template <int d>
ImplicitMpm<d>::ImplicitMpm(const MpmScene& scene, const ImplicitMpmOptions& options)
    : scene_(scene), options_(options), equations_(scene) {
  ELASTOGEN_CHECK(options.substeps >= 1, "substeps must be at least 1, got ", options.substeps);
}

/// step = -J^-1 r.
template <int d>
bool ImplicitMpm<d>::find_step(const double* y, const double* r, double tolerance, double* step) {
  const int64_t size = equations_.unknowns();
  equations_.linearise(y);
  bool solved = false;
  const bool can_factor = d == 2 && size <= options_.most_factored;
  // GMRES; in the plane only while it takes few iterations
  if (!factors_first_) {
    if (int64_t(work_.z.size()) != size) work_ = GmresWork<double>(size);
    const KrylovResult result = gmres(
        r, step, size, tolerance, can_factor ? kFewIterations : options_.max_iterations, work_,
        [&](const double* p, double* Jp) { equations_.product(p, Jp); },
        [&](const double* p, double* z) { equations_.precondition(p, z); });
    iterations_ += result.iterations;
    solved = result.stop != KrylovStop::kBreakdown;
    factors_first_ = can_factor && result.stop != KrylovStop::kConverged;
  }
  // factors where it did not converge
  if (factors_first_) {
    const fem::SparseMatrix& J = equations_.jacobian();
    if (equations_.pattern_version() != pattern_) factors_.reset(J);
    pattern_ = equations_.pattern_version();
    ++factored_;
    solved = factors_.factor(J) && factors_.solve(r, step, tolerance);
  }
  for (int64_t k = 0; k < size; ++k) step[k] = -step[k];
  return solved;
}

template <int d>
fem::RootResult ImplicitMpm<d>::solve(std::vector<double>& y) {
  fem::RootFunction f;
  f.unknowns = equations_.unknowns();
  f.residual = [&](const double* x, double* r) { equations_.residual(x, r); };
  f.step = [&](const double* x, const double* r, double tolerance, double* step) {
    return find_step(x, r, tolerance, step);
  };
  f.longest_step = [&](const double* x, const double* end) {
    return equations_.longest_step(x, end);
  };
  f.noise = [&](const double* x) { return equations_.noise(x); };
  return fem::solve_root(f,
                         {.tolerance = options_.tolerance * equations_.reference(),
                          .max_iterations = options_.max_newton,
                          .loosest_solve = kLooseSolve},
                         y.data());
}

template <int d>
MpmStepReport ImplicitMpm<d>::step(double time, Particles& p) {
  const Stopwatch watch;
  MpmStepReport report;
  const double dt = scene_.dt / options_.substeps;
  const Particles before = options_.substeps > 1 ? p : Particles();
  equations_.begin(p, time, dt);
  factors_first_ = false;
  const int64_t iterations = iterations_, factored = factored_;
  std::vector<double> y(size_t(equations_.unknowns()));
  // substeps on fixed nodes, each of which commits strain and stress
  for (int k = 0; k < options_.substeps && report.finite; ++k) {
    if (k > 0) equations_.go_on(time + k * dt);
    equations_.predict(y.data());
    const fem::RootResult result = solve(y);
    report.stop = result.stop;
    report.outer += result.iterations;
    report.residual = std::max(report.residual, result.residual / equations_.reference());
    report.finite = std::isfinite(result.residual);
    if (report.finite) equations_.commit(y.data(), p);
  }
  // the report of all substeps
  report.inner = int(iterations_ - iterations);
  report.factored = int(factored_ - factored);
  report.converged = report.finite && report.residual <= options_.tolerance;
  report.float64 = true;
  report.time = time + scene_.dt;
  // places and velocities of particles, or back to the start
  if (report.finite)
    equations_.transfer(p);
  else if (options_.substeps > 1)
    p = before;
  report.ms = watch.milliseconds();
  return report;
}

template class ImplicitMpm<2>;
template class ImplicitMpm<3>;

}  // namespace elastogen::mpm
