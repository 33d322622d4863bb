// SPDX-License-Identifier: Apache-2.0
// The published algorithm beside the two solvers of true equations, from the same state, on the
// same operator: run time against error of one step.
//
//   paper [beam|ball|bar|character|all] [VOXELS] [REPEATS]     a Markdown table
//   paper loops [VOXELS]                 1 ... 50 outer loops on the beam, as the paper's appendix
//   paper courant                        the printed operator below and above Courant number 1
//   paper json FILE [REPEATS]            all three as JSON, the first of 1000 voxels

#include "bench/measure.hpp"
#include "bench/scenes.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace elastogen::bench {
namespace {

constexpr int kGrowthSteps = 20;
constexpr double kPoisson = 0.3;

const char* name_of(Hourglass hourglass) {
  return hourglass == Hourglass::kOff ? "off" : "variance";
}

/// A step of one mode; NaN where it was refused.
struct Row {
  std::string scene;
  int64_t voxels = 0;
  double courant = 0;
  const char* hourglass = "";
  std::string_view mode;
  std::string loops;
  int modes = -1;  ///< latent size; -1: none
  double residual = 0, error = 0, ms = 0;
};

/// Residuals of 20 steps at a Courant number, as many as were finite.
struct Growth {
  double courant = 0;
  std::vector<double> residual;
};

Row row_of(const std::string& name, const Scene& scene, const SceneOptions& o,
           const SolverOptions& s, const Timing& t) {
  const StepReport& r = t.report;
  const bool paper = s.mode == SolverMode::kPaper;
  Row row;
  row.scene = name;
  row.voxels = scene.grid.voxel_count();
  row.courant = o.courant;
  row.hourglass = name_of(o.hourglass);
  row.mode = solver_name(s.mode);
  row.loops = paper ? fmt::format("{} x {}", s.paper.outer, s.paper.inner)
                    : fmt::format("{} / {}", r.outer, r.inner);
  if (paper) row.modes = s.paper.modes;
  row.residual = r.finite ? r.residual : NAN;
  row.error = r.finite ? t.error : NAN;
  row.ms = t.ms;
  return row;
}

/// The three modes on one scene: ours to three tolerances, the paper's with its printed settings.
void compare(const std::string& name, const SceneOptions& o, int repeats, std::vector<Row>& rows) {
  const BenchScene bench = bench_scene(name, o);
  const Reference reference = make_reference(bench.scene, bench.motion, kStepsBefore);
  std::vector<SolverOptions> all;
  for (const SolverMode mode : {SolverMode::kQuasi, SolverMode::kNewton})
    for (const double tolerance : {1e-1, 1e-2, 1e-3})
      all.push_back({.mode = mode, .tolerance = tolerance});
  for (const int modes : {0, 18, 36, 54, 81})
    all.push_back({.mode = SolverMode::kPaper, .paper = {10, 20, modes}});
  for (const SolverOptions& s : all)
    rows.push_back(row_of(name, bench.scene, o, s,
                          time_step(bench.scene, reference.start, s, repeats, reference.next.x)));
}

std::vector<Row> scenes(const std::string& name, double voxels, int repeats) {
  std::vector<Row> rows;
  for (const char* one : {"beam", "ball", "bar", "character"}) {
    if (name != one && name != "all") continue;
    for (const Hourglass hourglass : {Hourglass::kVariance, Hourglass::kOff})
      for (const double courant : {1.0, 3.0, 10.0})
        compare(one,
                {.voxels = voxels, .courant = courant, .poisson = kPoisson, .hourglass = hourglass},
                repeats, rows);
  }
  return rows;
}

std::vector<Row> loops(double voxels) {
  std::vector<Row> rows;
  for (const double courant : {1.0, 2.0, 5.0}) {
    const SceneOptions o{.voxels = voxels,
                         .courant = courant,
                         .poisson = kPoisson,
                         .hourglass = Hourglass::kVariance};
    const BenchScene bench = bench_scene("beam", o);
    const Reference reference = make_reference(bench.scene, bench.motion, kStepsBefore);
    for (const int outer : {1, 3, 5, 20, 50, 500}) {
      const SolverOptions s{.mode = SolverMode::kPaper, .paper = {outer, 20, 18}};
      rows.push_back(row_of("beam", bench.scene, o, s,
                            time_step(bench.scene, reference.start, s, 1, reference.next.x)));
    }
  }
  return rows;
}

/// The residual over 20 steps of the printed operator, nearly unloaded.
std::vector<Growth> courant() {
  std::vector<Growth> all;
  for (const double c : {0.5, 0.8, 0.95, 1.05, 1.5, 3.0}) {
    const SceneOptions o{
        .voxels = 500, .courant = c, .poisson = kPoisson, .hourglass = Hourglass::kOff};
    BenchScene bench = bench_scene("beam", o);
    bench.scene.gravity = {0, -1e-3, 0};  // so that N stays near I and only the sweeps decide
    State state = initial_state(bench.scene);
    Solver solver(bench.scene, {.mode = SolverMode::kPaper, .paper = {10, 20, 18}});
    Growth growth{.courant = c, .residual = {}};
    for (int k = 0; k < kGrowthSteps; ++k) {
      const StepReport r = solver.step(state);
      if (!r.finite) break;
      growth.residual.push_back(r.residual);
    }
    all.push_back(std::move(growth));
  }
  return all;
}

void print(const std::vector<Row>& rows) {
  fmt::print(
      "| scene | voxels | C | hourglass | mode | loops | modes | residual | error | ms |\n"
      "|---|---|---|---|---|---|---|---|---|---|\n");
  for (const Row& r : rows)
    fmt::print("| {} | {} | {} | {} | {} | {} | {} | {} | {} | {:.1f} |\n", r.scene, r.voxels,
               r.courant, r.hourglass, r.mode, r.loops, r.modes < 0 ? "" : fmt::to_string(r.modes),
               std::isnan(r.residual) ? "not finite" : fmt::format("{:.1e}", r.residual),
               std::isnan(r.residual) ? "refused" : fmt::format("{:.1e}", r.error), r.ms);
}

void print(const std::vector<Growth>& all) {
  fmt::print("| C | step 1 | 5 | 10 | 20 |\n|---|---|---|---|---|\n");
  for (const Growth& g : all) {
    fmt::print("| {} ", g.courant);
    for (const size_t k : {1, 5, 10, 20})
      fmt::print("| {} ", k <= g.residual.size()
                              ? fmt::format("{:.1e}", g.residual[k - 1])
                              : fmt::format("not finite at step {}", g.residual.size() + 1));
    fmt::print("|\n");
  }
}

std::string number(double value) {
  return std::isfinite(value) ? fmt::format("{}", value) : "null";
}

std::string json(const Row& r) {
  return fmt::format(
      R"({{"scene": "{}", "voxels": {}, "courant": {}, "poisson": {}, "hourglass": "{}", )"
      R"("mode": "{}", "loops": "{}", "modes": {}, "residual": {}, "error": {}, "ms": {}}})",
      r.scene, r.voxels, r.courant, kPoisson, r.hourglass, r.mode, r.loops,
      r.modes < 0 ? "null" : fmt::to_string(r.modes), number(r.residual), number(r.error),
      number(r.ms));
}

std::string json(const Growth& g) {
  std::string text;
  for (const double residual : g.residual) text += (text.empty() ? "" : ", ") + number(residual);
  return fmt::format(R"({{"courant": {}, "residual": [{}]}})", g.courant, text);
}

/// "name": [...], a line an entry.
template <class Entry>
std::string member(const char* name, const std::vector<Entry>& entries) {
  std::string text;
  for (const Entry& entry : entries) text += (text.empty() ? "\n  " : ",\n  ") + json(entry);
  return fmt::format("\"{}\": [{}\n ]", name, text);
}

void write_json(const char* path, int repeats) {
  const std::string text =
      fmt::format("{{\n {},\n {},\n {}\n}}\n", member("scenes", scenes("all", 1000, repeats)),
                  member("loops", loops(500)), member("courant", courant()));
  std::FILE* file = std::fopen(path, "w");
  const bool written = file && std::fwrite(text.data(), 1, text.size(), file) == text.size();
  if (!file || std::fclose(file) != 0 || !written)
    throw std::runtime_error(fmt::format("{} cannot be written", path));
}

}  // namespace
}  // namespace elastogen::bench

int main(int argc, char** argv) {
  using namespace elastogen::bench;
  const std::string name = argc > 1 ? argv[1] : "all";
  const double voxels = argc > 2 ? std::atof(argv[2]) : 1e4;
  const int repeats = argc > 3 ? std::atoi(argv[3]) : 3;
  if (name == "json" && argc > 2)
    write_json(argv[2], repeats);
  else if (name == "loops")
    print(loops(argc > 2 ? voxels : 500));
  else if (name == "courant")
    print(courant());
  else
    print(scenes(name, voxels, repeats));
}
