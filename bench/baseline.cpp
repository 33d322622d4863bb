// SPDX-License-Identifier: Apache-2.0
// The published algorithm as its readers would write it, in PyTorch, beside the solvers: the same
// scene, the same state, one step. Its result is judged by the float64 potential and the reference
// of the solvers.
#include "bench/baseline_scene.hpp"
#include "bench/bench.hpp"
#include "bench/lattice.hpp"
#include "bench/measure.hpp"
#include "bench/process.hpp"
#include "bench/timing.hpp"
#include "core/error.hpp"
#include "core/reduce.hpp"
#include "core/time_scheme.hpp"
#include "io/safe_file.hpp"
#include "network/potential/incremental_potential.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cstdio>
#include <filesystem>
#include <optional>

namespace elastogen::bench {
namespace {

constexpr int kStepsTimed = 5;
constexpr double kReferenceTolerance = 1e-9;
constexpr int kNoTorch = 3, kNotStarted = 127;  // exit codes of the script

/// A step that all of them take.
struct Case {
  Scene scene;
  State start;
  Array<double> reference;  ///< positions after it
  double reference_residual = 0;
};

/// Steps to the tolerance of the task from rest, then the step itself to the tight one.
Case make_case(const BenchTask& task, double size, double courant, double poisson) {
  Case c{.scene = cantilever({.voxels = size,
                              .courant = courant,
                              .poisson = poisson,
                              .hourglass = Hourglass::kVariance}),
         .start = {},
         .reference = {}};
  Solver before(c.scene, {.mode = SolverMode::kQuasi, .tolerance = task.tolerance});
  c.start = initial_state(c.scene);
  for (int k = 0; k < kStepsBefore; ++k) before.step(c.start);
  State next = c.start;
  Solver exact(c.scene, {.mode = SolverMode::kNewton, .tolerance = kReferenceTolerance});
  c.reference_residual = exact.step(next).residual;
  c.reference = std::move(next.x);
  return c;
}

/// |grad Phi| / |M g_ref| at positions x after a step from the start.
double true_residual(const Case& c, const Array<double>& x) {
  IncrementalPotential potential(c.scene);
  potential.begin_step(c.start, step_scheme(c.scene, c.start));
  std::vector<double> u(size_t(x.size())), gradient(u.size());
  for (int64_t k = 0; k < x.size(); ++k) u[size_t(k)] = x.data()[k] - c.scene.grid.rest.data()[k];
  potential.residual(u.data(), gradient.data());
  return norm(gradient.data(), int64_t(gradient.size())) / reference_force(c.scene);
}

Json solver_row(const Case& c, const BenchTask& task, SolverMode mode) {
  const bool card = resolved(task.device) == Device::kCuda;
  const SolverOptions options{.mode = mode,
                              .device = card ? Device::kCuda : Device::kCpu,
                              .tolerance = task.tolerance,
                              .paper = task.loops};
  const Timing t = time_step(c.scene, c.start, options,
                             task.repeats > 0 ? task.repeats : kStepsTimed, c.reference);
  return {{"run", std::string("elastogen ") + std::string(solver_name(mode))},
          {"device", card ? "cuda" : "cpu"},
          {"ms", t.ms},
          {"residual", t.report.residual},
          {"error", t.report.finite ? Json(t.error) : Json(nullptr)},
          {"converged", t.report.converged},
          {"outer", t.report.outer},
          {"inner", t.report.inner},
          {"setup_seconds", t.setup_seconds}};
}

/// The script in one of its modes; null members where it failed.
Json script_row(const Case& c, const BenchTask& task, const std::string& run,
                const std::string& folder) {
  // a run is named MODE-SVD
  const size_t dash = run.find('-');
  const std::string out = folder + "/" + run;
  const bool card = resolved(task.device) == Device::kCuda;
  const int code = run_program(
      task.python, {task.script, folder, "--out", out, "--mode", run.substr(0, dash), "--svd",
                    run.substr(dash + 1), "--device", card ? "cuda" : "cpu", "--repeat",
                    std::to_string(task.repeats > 0 ? task.repeats : kStepsTimed)});
  ELASTOGEN_CHECK(code != kNotStarted, task.python, ": cannot be started; name one with --python");
  ELASTOGEN_CHECK(code != kNoTorch, task.python,
                  " has no PyTorch; name one that has with --python");
  // a run that failed has its exit code in place of numbers
  Json row = {{"run", "paper in PyTorch, " + run}, {"device", card ? "cuda" : "cpu"}};
  if (code != 0) {
    row["exit_code"] = code;
    return row;
  }
  // residual and error of the positions that the script wrote
  const Json result = Json::parse(read_file(out + "/result.json"));
  const Array<double> x = read_baseline_positions(out, c.scene);
  row["ms"] = spread_of(result["ms"].get<std::vector<double>>()).median;
  row["residual"] = true_residual(c, x);
  row["error"] = rms(c.scene, x, c.reference) / rms(c.scene, c.start.x, c.reference);
  row["converged"] = row["residual"] <= task.tolerance;
  row["outer"] = task.loops.outer, row["inner"] = task.loops.inner;
  for (const char* key : {"setup_seconds", "card", "torch", "dtype", "peak_bytes"})
    row[key] = result[key];
  return row;
}

/// A line of the table, with how much slower and how much farther off than quasi it is.
void print(const Json& row, const Json& ours) {
  if (!row.contains("ms") || row["error"].is_null()) {
    fmt::print("{:40} failed\n", row["run"].get<std::string>());
  } else {
    const auto number = [](const Json& r, const char* key) { return r[key].get<double>(); };
    fmt::print(
        "{:40} {:4} {:10.2f} ms   residual {:.1e}   error {:.1e}   {:8.1f} x the time, {:.1e} "
        "x the error of quasi\n",
        row["run"].get<std::string>(), row["device"].get<std::string>(), number(row, "ms"),
        number(row, "residual"), number(row, "error"), number(row, "ms") / number(ours, "ms"),
        number(row, "error") / number(ours, "error"));
  }
  std::fflush(stdout);
}

Json run_case(const BenchTask& task, double size, double courant, double poisson) {
  const Case c = make_case(task, size, courant, poisson);
  fmt::print("beam, {} voxels, C {}, nu {}\n", c.scene.grid.voxel_count(), courant, poisson);
  const TemporaryFolder folder;
  write_baseline_scene(folder.path(), c.scene, c.start, task.loops);
  Json rows = Json::array();
  const auto add = [&](Json row) {
    rows.push_back(std::move(row));
    print(rows.back(), rows.front());
  };
  for (const SolverMode mode : {SolverMode::kQuasi, SolverMode::kNewton, SolverMode::kPaper})
    add(solver_row(c, task, mode));
  for (const std::string& run : task.runs) add(script_row(c, task, run, folder.path()));
  return {{"scene", "beam"},
          {"voxels", c.scene.grid.voxel_count()},
          {"courant", courant},
          {"poisson", poisson},
          {"hourglass", "variance"},
          {"tolerance", task.tolerance},
          {"loops",
           {{"outer", task.loops.outer}, {"inner", task.loops.inner}, {"modes", task.loops.modes}}},
          {"reference_residual", c.reference_residual},
          {"rows", rows}};
}

/// The script that is named, else that of the folder one is in or of the sources.
std::string find_script(const std::string& named) {
  const std::string beside = "bench/baselines/elastogen_paper.py";
  std::vector<std::string> places = {named};
  if (named.empty()) places = {beside, ELASTOGEN_BASELINE};
  for (const std::string& path : places)
    if (std::filesystem::is_regular_file(path)) return path;
  throw Error(concat(places[0], ": there is no such script; name it with --script"));
}

}  // namespace

Json measure_baseline(const BenchTask& asked) {
  BenchTask task = asked;
  task.script = find_script(asked.script);
  if (resolved(task.device) == Device::kCpu)
    std::erase_if(task.runs, [](const std::string& run) { return run.starts_with("graph"); });
  std::vector<double> sizes = task.sizes;
  if (sizes.empty())
    sizes =
        resolved(task.device) == Device::kCuda ? std::vector{3.2e4, 2.56e5, 1e6} : std::vector{4e3};
  Json result = Json::array();
  for (const double size : sizes)
    for (const double courant : task.courants)
      for (const double poisson : task.poissons)
        result.push_back(run_case(task, size, courant, poisson));
  return result;
}

}  // namespace elastogen::bench
