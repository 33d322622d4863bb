// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/integrators/implicit_mpm.hpp"

#include "core/stopwatch.hpp"
#include "mpm_fem/mpm/g2p.hpp"
#include "mpm_fem/mpm/point_update.hpp"

#include <cmath>

namespace elastogen::mpm {

template <int d>
ImplicitMpm<d>::ImplicitMpm(const MpmScene& scene, const ImplicitMpmOptions& options)
    : scene_(scene), options_(options), equations_(scene) {}

template <int d>
fem::RootResult ImplicitMpm<d>::solve(std::vector<double>& y) {
  fem::RootFunction f;
  f.unknowns = equations_.unknowns();
  if (int64_t(work_.z.size()) != f.unknowns) work_ = GmresWork<double>(f.unknowns);
  f.residual = [&](const double* x, double* r) { equations_.residual(x, r); };
  f.step = [&](const double* x, const double* r, double tolerance, double* step) {
    equations_.linearise(x);
    const KrylovResult solved = gmres(
        r, step, f.unknowns, tolerance, options_.max_iterations, work_,
        [&](const double* p, double* Jp) { equations_.product(p, Jp); },
        [&](const double* p, double* z) { equations_.precondition(p, z); });
    iterations_ += solved.iterations;
    for (int64_t k = 0; k < f.unknowns; ++k) step[k] = -step[k];
    return solved.stop != KrylovStop::kBreakdown;
  };
  f.longest_step = [&](const double* x, const double* end) {
    return equations_.longest_step(x, end);
  };
  f.noise = [&](const double* x) { return equations_.noise(x); };
  return fem::solve_root(f,
                         {.tolerance = options_.tolerance * equations_.reference(),
                          .max_iterations = options_.max_newton},
                         y.data());
}

template <int d>
void ImplicitMpm<d>::finish(const std::vector<double>& y, Particles& p) {
  const ParticleGrid<d>& grid = equations_.grid();
  Array<double> u(grid.nodes(), 3);
  equations_.motion(y.data(), u);
  gather<d>(grid, p.x, u, [&](int32_t k, const Spline<d>& s, int place, const double* tile) {
    Mat3<double> now = nodal_gradient<d>(s, place, tile);
    for (int a = 0; a < 3; ++a) now(a, a) += 1;
    Mat3<double> F = now * load_matrix(p.F.row(k));
    std::visit([&](const auto& law) { end_step<d>(law, F, p.history(k), p.stress.row(k)); },
               equations_.laws()[size_t(p.solid(k))]);
    store_matrix(F, p.F.row(k));
  });
  Array<double> v = u;
  for (int64_t k = 0; k < v.size(); ++k) v.data()[k] /= scene_.dt;
  grid_to_particles<d>(grid, u, equations_.start().velocity, v, scene_.transfer, scene_.dt, p);
}

template <int d>
MpmStepReport ImplicitMpm<d>::step(double time, Particles& p) {
  const Stopwatch watch;
  MpmStepReport report;
  equations_.begin(p, time, scene_.dt);
  std::vector<double> y(size_t(equations_.unknowns()));
  equations_.predict(y.data());
  const int64_t before = iterations_;
  const fem::RootResult result = solve(y);
  report.stop = result.stop;
  report.outer = result.iterations;
  report.inner = int(iterations_ - before);
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
