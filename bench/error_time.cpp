// SPDX-License-Identifier: Apache-2.0
// Run time against error: one step of each scene by each solver mode at several tolerances, from
// the same state, against newton at 1e-10. The error is the mass-weighted rms distance to the
// reference over the rms motion of the step.
//
//   error_time [beam|ball] [VOXELS] [REPEATS] [C NU]     prints a Markdown table; without C and NU
//                                                        of all nine combinations

#include "bench/scenes.hpp"
#include "io/report_file.hpp"
#include "network/solver.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

namespace elastogen::bench {
namespace {

constexpr int kStepsBefore = 2;

double rms(const Scene& scene, const Array<double>& a, const Array<double>& b) {
  double sum = 0, mass = 0;
  for (int64_t n = 0; n < a.rows(); ++n) {
    mass += scene.mass(n);
    for (int d = 0; d < 3; ++d) sum += scene.mass(n) * std::pow(a(n, d) - b(n, d), 2);
  }
  return std::sqrt(sum / mass);
}

struct Timing {
  StepReport report;
  double ms = 0, error = 0, setup_seconds = 0;
};

/// The median of several steps from the same state; a first one warms up.
Timing time_step(const Scene& scene, const State& start, const SolverOptions& options, int repeats,
                 const Array<double>& reference) {
  const auto begin = std::chrono::steady_clock::now();
  Solver solver(scene, options);
  Timing timing;
  timing.setup_seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  std::vector<double> ms;
  for (int k = 0; k <= repeats; ++k) {
    State state = start;
    timing.report = solver.step(state);
    if (k > 0) ms.push_back(timing.report.ms);
    timing.error = rms(scene, state.x, reference) / rms(scene, start.x, reference);
  }
  timing.ms = quantile(ms, 0.5);
  return timing;
}

void run(const std::string& name, double voxels, int repeats, const std::vector<double>& courants,
         const std::vector<double>& poissons) {
  fmt::print(
      "| scene | voxels | C | nu | mode | tolerance | outer | inner | float64 | residual | "
      "error | ms | setup s |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const double courant : courants)
    for (const double poisson : poissons) {
      const SceneOptions o{.voxels = voxels, .courant = courant, .poisson = poisson};
      const Scene scene = name == "beam" ? cantilever(o) : porous_ball(o);
      Solver exact(scene, {.mode = SolverMode::kNewton, .tolerance = 1e-10});
      State start = initial_state(scene);
      for (int k = 0; k < kStepsBefore; ++k) exact.step(start);
      State reference = start;
      const StepReport certificate = exact.step(reference);
      if (certificate.residual > 1e-9)
        fmt::print("reference at {:.1e} only\n", certificate.residual);
      for (const SolverMode mode : {SolverMode::kQuasi, SolverMode::kNewton})
        for (const double tolerance : {1e-1, 1e-2, 1e-3, 1e-4}) {
          const Timing t =
              time_step(scene, start, {.mode = mode, .tolerance = tolerance}, repeats, reference.x);
          const StepReport& r = t.report;
          fmt::print(
              "| {} | {} | {} | {} | {} | {:.0e} | {} | {} | {} | {:.1e} | {:.1e} | {:.1f} | "
              "{:.2f} |\n",
              name, scene.grid.voxel_count(), courant, poisson, solver_name(mode), tolerance,
              r.outer, r.inner, r.float64 ? "yes" : "no", r.residual, t.error, t.ms,
              t.setup_seconds);
          std::fflush(stdout);
        }
    }
}

}  // namespace
}  // namespace elastogen::bench

int main(int argc, char** argv) {
  const std::string name = argc > 1 ? argv[1] : "beam";
  std::vector<double> courants = {3, 10, 30}, poissons = {0.3, 0.45, 0.49};
  if (argc > 5) courants = {std::atof(argv[4])}, poissons = {std::atof(argv[5])};
  elastogen::bench::run(name, argc > 2 ? std::atof(argv[2]) : 1e4,
                        argc > 3 ? std::atoi(argv[3]) : 3, courants, poissons);
}
