// SPDX-License-Identifier: Apache-2.0
// The published algorithm beside the two solvers of true equations, from the same state, on the
// same operator: run time against error of one step.
//
//   paper [beam|ball|bar|character|all] [VOXELS] [REPEATS]     a Markdown table
//   paper loops [VOXELS]                 1 ... 50 outer loops on the beam, as the paper's appendix
//   paper courant                        the printed operator below and above Courant number 1

#include "bench/measure.hpp"
#include "bench/scenes.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <string>
#include <vector>

namespace elastogen::bench {
namespace {

constexpr int kStepsBefore = 2;

const char* name_of(Hourglass hourglass) {
  return hourglass == Hourglass::kOff ? "off" : "variance";
}

void print_head() {
  fmt::print(
      "| scene | voxels | C | nu | hourglass | mode | loops | modes | residual | error | ms |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|\n");
}

void print_row(const std::string& name, const Scene& scene, const SceneOptions& o,
               const SolverOptions& s, const Timing& t) {
  const StepReport& r = t.report;
  const bool paper = s.mode == SolverMode::kPaper;
  const std::string loops = paper ? fmt::format("{} x {}", s.paper.outer, s.paper.inner)
                                  : fmt::format("{} / {}", r.outer, r.inner);
  fmt::print("| {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {:.1f} |\n", name,
             scene.grid.voxel_count(), o.courant, o.poisson, name_of(o.hourglass),
             solver_name(s.mode), loops, paper ? fmt::format("{}", s.paper.modes) : "",
             r.finite ? fmt::format("{:.1e}", r.residual) : "not finite",
             r.finite ? fmt::format("{:.1e}", t.error) : "refused", t.ms);
  std::fflush(stdout);
}

/// The three modes on one scene: ours to three tolerances, the paper's with its printed settings.
void compare(const std::string& name, const SceneOptions& o, int repeats) {
  const BenchScene bench = bench_scene(name, o);
  const Reference reference = make_reference(bench.scene, bench.motion, kStepsBefore);
  std::vector<SolverOptions> all;
  for (const SolverMode mode : {SolverMode::kQuasi, SolverMode::kNewton})
    for (const double tolerance : {1e-1, 1e-2, 1e-3})
      all.push_back({.mode = mode, .tolerance = tolerance});
  for (const int modes : {0, 18, 36, 54, 81})
    all.push_back({.mode = SolverMode::kPaper, .paper = {10, 20, modes}});
  for (const SolverOptions& s : all)
    print_row(name, bench.scene, o, s,
              time_step(bench.scene, reference.start, s, repeats, reference.next.x));
}

void scenes(const std::string& name, double voxels, int repeats) {
  print_head();
  for (const char* one : {"beam", "ball", "bar", "character"}) {
    if (name != one && name != "all") continue;
    for (const Hourglass hourglass : {Hourglass::kVariance, Hourglass::kOff})
      for (const double courant : {1.0, 3.0, 10.0})
        compare(one, {.voxels = voxels, .courant = courant, .poisson = 0.3, .hourglass = hourglass},
                repeats);
  }
}

void loops(double voxels) {
  print_head();
  for (const double courant : {1.0, 2.0, 5.0}) {
    const SceneOptions o{
        .voxels = voxels, .courant = courant, .poisson = 0.3, .hourglass = Hourglass::kVariance};
    const BenchScene bench = bench_scene("beam", o);
    const Reference reference = make_reference(bench.scene, bench.motion, kStepsBefore);
    for (const int outer : {1, 3, 5, 20, 50, 500}) {
      const SolverOptions s{.mode = SolverMode::kPaper, .paper = {outer, 20, 18}};
      print_row("beam", bench.scene, o, s,
                time_step(bench.scene, reference.start, s, 1, reference.next.x));
    }
  }
}

/// The residual over 20 steps of the printed operator, nearly unloaded.
void courant() {
  fmt::print("| C | step 1 | 5 | 10 | 20 |\n|---|---|---|---|---|\n");
  for (const double c : {0.5, 0.8, 0.95, 1.05, 1.5, 3.0}) {
    const SceneOptions o{.voxels = 500, .courant = c, .poisson = 0.3, .hourglass = Hourglass::kOff};
    BenchScene bench = bench_scene("beam", o);
    bench.scene.gravity = {0, -1e-3, 0};  // so that N stays near I and only the sweeps decide
    State state = initial_state(bench.scene);
    Solver solver(bench.scene, {.mode = SolverMode::kPaper, .paper = {10, 20, 18}});
    fmt::print("| {} ", c);
    int refused = 0;
    for (int k = 1; k <= 20; ++k) {
      const StepReport r = refused > 0 ? StepReport{} : solver.step(state);
      if (refused == 0 && !r.finite) refused = k;
      if (k != 1 && k != 5 && k != 10 && k != 20) continue;
      if (refused > 0)
        fmt::print("| not finite at step {} ", refused);
      else
        fmt::print("| {:.1e} ", r.residual);
    }
    fmt::print("|\n");
  }
}

}  // namespace
}  // namespace elastogen::bench

int main(int argc, char** argv) {
  using namespace elastogen::bench;
  const std::string name = argc > 1 ? argv[1] : "all";
  const double voxels = argc > 2 ? std::atof(argv[2]) : 1e4;
  if (name == "loops")
    loops(argc > 2 ? voxels : 500);
  else if (name == "courant")
    courant();
  else
    scenes(name, voxels, argc > 3 ? std::atoi(argv[3]) : 3);
}
