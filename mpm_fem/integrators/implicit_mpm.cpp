// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/integrators/implicit_mpm.hpp"

#include "core/stopwatch.hpp"
#include "mpm_fem/mpm/end_step.hpp"
#include "mpm_fem/mpm/g2p.hpp"
#include "mpm_fem/mpm/pack_laws.hpp"

#include <cmath>

namespace elastogen::mpm {

constexpr double kLooseSolve = 0.1;  // of the linear systems far from the root
constexpr int kFewIterations = 60;   // of GMRES, after which factors cost less

template <int d>
ImplicitMpm<d>::ImplicitMpm(const MpmScene& scene, const ImplicitMpmOptions& options)
    : scene_(scene), options_(options), equations_(scene) {}

/// step = -J^-1 r.
template <int d>
bool ImplicitMpm<d>::find_step(const double* y, const double* r, double tolerance, double* step) {
  const int64_t size = equations_.unknowns();
  equations_.linearise(y);
  bool solved = false;
  const bool can_factor = d == 2 && size <= options_.most_factored;
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
void ImplicitMpm<d>::finish(const std::vector<double>& y, Particles& p) {
  const ParticleGrid<d>& grid = equations_.grid();
  Array<double> v(grid.nodes(), 3);
  equations_.motion(y.data(), v);
  for (int64_t k = 0; k < v.size(); ++k) v.data()[k] /= scene_.dt;
  grid_to_particles<d>(grid, {}, equations_.start().velocity, v, scene_.transfer, scene_.dt, p,
                       [&](int64_t k, int begin, const Mat3<WidePack>& G) {
                         const CellPack& pack = grid.packs()[size_t(k)];
                         end_step<d>(equations_.laws(), pack, begin,
                                     deformed(G) * matrix_lanes<WidePack>(p.F, pack, begin), p);
                       });
}

template <int d>
MpmStepReport ImplicitMpm<d>::step(double time, Particles& p) {
  const Stopwatch watch;
  MpmStepReport report;
  equations_.begin(p, time, scene_.dt);
  factors_first_ = false;
  std::vector<double> y(size_t(equations_.unknowns()));
  equations_.predict(y.data());
  const int64_t before = iterations_, factored = factored_;
  const fem::RootResult result = solve(y);
  report.stop = result.stop;
  report.outer = result.iterations;
  report.inner = int(iterations_ - before);
  report.factored = int(factored_ - factored);
  report.residual = result.residual / equations_.reference();
  report.converged = report.residual <= options_.tolerance;
  report.finite = std::isfinite(result.residual);
  report.float64 = true;
  report.time = time + scene_.dt;
  if (report.finite) finish(y, p);
  report.ms = watch.milliseconds();
  return report;
}

template class ImplicitMpm<2>;
template class ImplicitMpm<3>;

}  // namespace elastogen::mpm
