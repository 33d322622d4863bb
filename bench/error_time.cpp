// SPDX-License-Identifier: Apache-2.0
// One step of each scene by each solver, at several tolerances or with several budgets of loops,
// all from one state. The reference is newton at 1e-10; the error is the mass-weighted rms distance
// to it over the rms motion of the step.
#include "bench/bench.hpp"
#include "bench/lattice.hpp"
#include "bench/measure.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cstdio>

namespace elastogen::bench {
namespace {

constexpr int kSolveRepeats = 5;

/// The runs of a solver: a tolerance each, or outer loops.
std::vector<SolverOptions> budgets(const BenchTask& task, SolverMode mode) {
  std::vector<SolverOptions> result;
  SolverOptions o{.mode = mode};
  if (resolved(task.device) == Device::kCuda) o.device = Device::kCuda;
  if (mode == SolverMode::kPaper)
    for (const int outer : {1, 3, 10, 30, 100}) {
      o.paper = {outer, task.loops.inner, task.loops.modes};
      result.push_back(o);
    }
  else
    for (const double tolerance : task.tolerances) {
      o.tolerance = tolerance;
      result.push_back(o);
    }
  return result;
}

Json json(const std::string& name, const Scene& scene, double fill, const SolverOptions& s,
          const Timing& t) {
  const StepReport& r = t.report;
  const bool paper = s.mode == SolverMode::kPaper;
  // print the result
  fmt::print(
      "{} {} C {:.4g} nu {} fill {}: {:6} {:>7}: {:9.2f} ms, residual {:.1e}, error {:.1e}\n", name,
      scene.grid.voxel_count(), courant_number(scene), scene.materials[0].poisson, fill,
      solver_name(s.mode),
      paper ? fmt::format("{} x {}", s.paper.outer, s.paper.inner)
            : fmt::format("{:.0e}", s.tolerance),
      t.ms, r.residual, t.error);
  std::fflush(stdout);
  // null where there is no tolerance or no finite number
  return {{"scene", name},
          {"voxels", scene.grid.voxel_count()},
          {"courant", courant_number(scene)},
          {"poisson", scene.materials[0].poisson},
          {"fill", fill},
          {"solver", solver_name(s.mode)},
          {"hourglass", paper ? "variance" : "full"},
          {"device", s.device == Device::kCuda ? "cuda" : "cpu"},
          {"tolerance", paper ? Json(nullptr) : Json(s.tolerance)},
          {"outer", r.outer},
          {"inner", r.inner},
          {"float64", r.float64},
          {"residual", r.finite ? Json(r.residual) : Json(nullptr)},
          {"error", r.finite ? Json(t.error) : Json(nullptr)},
          {"ms", t.ms},
          {"setup_seconds", t.setup_seconds}};
}

/// The solvers of one hourglass term on one scene.
void add_rows(const BenchTask& task, const std::string& name, SceneOptions o, double fill,
              bool paper, Json& rows) {
  std::vector<SolverOptions> runs;
  for (const SolverMode mode : task.solvers)
    if ((mode == SolverMode::kPaper) == paper)
      for (const SolverOptions& s : budgets(task, mode)) runs.push_back(s);
  if (runs.empty()) return;
  o.hourglass = paper ? Hourglass::kVariance : Hourglass::kFull;
  const Scene scene = step_scene(name, o, fill);
  const Reference reference = make_reference(scene, {}, kStepsBefore);
  const int repeats = task.repeats > 0 ? task.repeats : kSolveRepeats;
  for (const SolverOptions& s : runs)
    rows.push_back(json(name, scene, fill, s,
                        time_step(scene, reference.start, s, repeats, reference.next.x)));
}

}  // namespace

Json measure_error_time(const BenchTask& task) {
  const std::vector<double> sizes = task.sizes.empty() ? std::vector{1e4} : task.sizes;
  Json rows = Json::array();
  for (const std::string& name : task.scenes) {
    // C, nu and fill of c84 are its own, and only the beam has a fill
    const bool own = name == "c84", beam = name == "beam";
    for (const double size : sizes)
      for (const double courant : own ? std::vector{10.0} : task.courants)
        for (const double poisson : own ? std::vector{0.4} : task.poissons)
          for (const double fill : beam ? task.fills : std::vector{1.0})
            for (const bool paper : {false, true})
              add_rows(task, name, {.voxels = size, .courant = courant, .poisson = poisson}, fill,
                       paper, rows);
  }
  return rows;
}

}  // namespace elastogen::bench
