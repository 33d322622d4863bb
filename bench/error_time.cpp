// SPDX-License-Identifier: Apache-2.0
// Run time against error: one step of each scene by each solver mode at several tolerances, from
// the same state, against newton at 1e-10. The error is the mass-weighted rms distance to the
// reference over the rms motion of the step.
//
//   error_time [beam|ball] [VOXELS] [REPEATS] [C NU]     prints a Markdown table; without C and NU
//                                                        of all nine combinations

#include "bench/measure.hpp"
#include "bench/scenes.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <string>
#include <vector>

namespace elastogen::bench {
namespace {

constexpr int kStepsBefore = 2;

void run(const std::string& name, double voxels, int repeats, const std::vector<double>& courants,
         const std::vector<double>& poissons) {
  fmt::print(
      "| scene | voxels | C | nu | mode | tolerance | outer | inner | float64 | residual | "
      "error | ms | setup s |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const double courant : courants)
    for (const double poisson : poissons) {
      const SceneOptions o{.voxels = voxels, .courant = courant, .poisson = poisson};
      const Scene scene = name == "beam" ? cantilever(o) : porous_ball(o);
      const Reference reference = make_reference(scene, {}, kStepsBefore);
      for (const SolverMode mode : {SolverMode::kQuasi, SolverMode::kNewton})
        for (const double tolerance : {1e-1, 1e-2, 1e-3, 1e-4}) {
          const Timing t = time_step(scene, reference.start, {.mode = mode, .tolerance = tolerance},
                                     repeats, reference.next.x);
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
