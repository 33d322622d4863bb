// SPDX-License-Identifier: Apache-2.0
// A body that yields under a collider, by implicit steps of several lengths and by explicit steps,
// compared with fine implicit steps: the comparison of PlasticityNet (Li et al. 2022, figure 5c,
// table 1). Their explicit run has a lower Young's modulus, which allows longer steps; so has one
// here.
//
//   bench_metal_frame SCENE.toml [--explicit] [--json FILE] [--fine DT] [--implicit DT,DT]
//                     [--frames N] [--explicit-frames N] [--explicit-dt DT]
//
// SCENE has a file of triangles or tetrahedra. The push of its last collider is reported. Large
// scenes may take longer fine steps, and fewer frames of explicit steps than of implicit ones.

#include "cli/options.hpp"
#include "core/stopwatch.hpp"
#include "mpm_fem/integrators/explicit_fem.hpp"
#include "mpm_fem/integrators/parted_fem.hpp"
#include "scene/fem_scene.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <sstream>

namespace elastogen::bench {
namespace {

constexpr double kLonger = 10;  // of explicit steps where Young's modulus is less by its square

struct Wanted {
  std::string scene, json;
  double fine = 2e-4;                                 // dt of the reference [s]
  std::vector<double> implicit = {1e-2, 2e-3, 1e-3};  // [s]
  double explicit_dt = 1e-6;                          // [s]
  int64_t frames = 0, explicit_frames = 0;            // 0: all of the scene
  bool with_explicit = false;
};

struct Played {
  std::string name;
  double dt = 0, young = 0;
  int64_t steps = 0, drafts = 0, solves = 0, parts = 0, halvings = 0;
  double seconds = 0, residual = 0;
  std::vector<Array<double>> u = {};  // at the end of each frame [m]
  std::vector<double> push = {};      // of the last collider along y, at the end of each frame [N]
};

/// Plays the frames, one call of advance(state) for a step; calls pushes() at the end of each.
template <class Advance, class Pushes>
void play(const fem::FemScene& scene, int64_t frames, double frame, const Advance& advance,
          const Pushes& pushes, Played& run) {
  fem::FemState state = rest_state(scene);
  const int64_t per_frame = std::lround(frame / scene.dt);
  const Stopwatch watch;
  for (int64_t f = 0; f < frames; ++f) {
    for (int64_t k = 0; k < per_frame; ++k, ++run.steps) advance(state);
    run.u.push_back(state.u);
    run.push.push_back(pushes(state).back()[1]);
  }
  run.seconds = watch.seconds();
}

Played implicit_run(fem::FemScene scene, const AnimateOptions& o, int64_t frames, double dt) {
  scene.contact.slip_range *= dt / scene.dt;
  scene.dt = dt;
  Played run{fmt::format("implicit {:g} s", dt), dt, scene.materials[0].young};
  fem::ImplicitFem solver(scene, {.tolerance = o.solver.tolerance});
  const auto advance = [&](fem::FemState& state) {
    const fem::FemStepReport report = step_in_parts(solver, state);
    run.drafts += !report.converged;
    run.solves += report.outer, run.parts += report.parts, run.halvings += report.halvings;
    run.residual = std::max(run.residual, report.residual);
  };
  play(
      scene, frames, 1 / o.fps, advance,
      [&](const fem::FemState& state) { return solver.pushes(state.u); }, run);
  return run;
}

Played explicit_run(fem::FemScene scene, const AnimateOptions& o, int64_t frames, double dt,
                    double share) {
  scene.dt = dt;
  for (Material& m : scene.materials) m.young *= share;
  for (int64_t p = 0; p < scene.contact.stiffness.rows(); ++p) scene.contact.stiffness(p) *= share;
  Played run{fmt::format("explicit {:g} s", dt), dt, scene.materials[0].young};
  fem::ExplicitFem solver(scene);
  play(
      scene, frames, 1 / o.fps, [&](fem::FemState& state) { solver.step(state); },
      [&](const fem::FemState&) { return solver.pushes(); }, run);
  return run;
}

double diagonal_of(const Array<double>& rest) {
  double square = 0;
  for (int d = 0; d < 3; ++d) {
    double lower = 1e300, upper = -1e300;
    for (int64_t n = 0; n < rest.rows(); ++n)
      lower = std::min(lower, rest(n, d)), upper = std::max(upper, rest(n, d));
    square += (upper - lower) * (upper - lower);
  }
  return std::sqrt(square);
}

double mean_distance(const Array<double>& a, const Array<double>& b) {
  double sum = 0;
  for (int64_t n = 0; n < a.rows(); ++n)
    sum += std::hypot(a(n, 0) - b(n, 0), a(n, 1) - b(n, 1), a(n, 2) - b(n, 2));
  return sum / double(a.rows());
}

nlohmann::ordered_json row_of(const Played& run, const Played& fine, double diagonal) {
  std::vector<double> distance;
  for (size_t f = 0; f < run.u.size(); ++f)
    distance.push_back(mean_distance(run.u[f], fine.u[f]) / diagonal);
  double mean = 0;
  for (const double d : distance) mean += d / double(distance.size());
  return {{"name", run.name},
          {"dt", run.dt},
          {"young", run.young},
          {"steps", run.steps},
          {"drafts", run.drafts},
          {"solves", run.solves},
          {"parts", run.parts},
          {"halvings", run.halvings},
          {"residual", run.residual},
          {"seconds_a_step", run.seconds / double(run.steps)},
          {"worst", *std::max_element(distance.begin(), distance.end())},
          {"mean", mean},
          {"distance", distance},
          {"push", run.push}};
}

nlohmann::ordered_json result_of(const fem::FemScene& scene, const AnimateOptions& o,
                                 const Wanted& wanted, const std::vector<Played>& runs) {
  nlohmann::ordered_json result = {
      {"scene", wanted.scene.substr(wanted.scene.find_last_of('/') + 1)},
      {"element", fem::element_name(scene.mesh.element)},
      {"nodes", scene.mesh.rest.rows()},
      {"elements", scene.mesh.elements.rows()},
      {"frame", 1 / o.fps},
      {"fine", wanted.fine}};
  for (const Played& run : runs)
    result["rows"].push_back(row_of(run, runs[0], diagonal_of(scene.mesh.rest)));
  return result;
}

std::vector<Played> runs_of(const fem::FemScene& scene, const AnimateOptions& o,
                            const Wanted& wanted) {
  const int64_t frames = wanted.frames ? wanted.frames : o.frames;
  const int64_t few = wanted.explicit_frames ? wanted.explicit_frames : frames;
  std::vector<Played> runs;
  const auto take = [&](Played run) {
    fmt::print("{}: {} steps, {:.3g} s each, {} drafts\n", run.name, run.steps,
               run.seconds / double(run.steps), run.drafts);
    std::fflush(stdout);
    runs.push_back(std::move(run));
    // what there is, should the program be ended
    if (!wanted.json.empty())
      std::ofstream(wanted.json) << result_of(scene, o, wanted, runs).dump(1) << '\n';
  };
  take(implicit_run(scene, o, frames, wanted.fine));
  for (const double dt : wanted.implicit) take(implicit_run(scene, o, frames, dt));
  if (!wanted.with_explicit) return runs;
  take(explicit_run(scene, o, few, kLonger * wanted.explicit_dt, 1 / (kLonger * kLonger)));
  take(explicit_run(scene, o, few, wanted.explicit_dt, 1));
  return runs;
}

void print(const nlohmann::ordered_json& rows) {
  fmt::print("\n| run | s a step | solves a step | worst frame | mean | drafts |\n");
  fmt::print("|---|---|---|---|---|---|\n");
  for (const auto& r : rows)
    fmt::print("| {} | {:.3g} | {:.2f} | {:.2e} | {:.2e} | {} |\n", r["name"].get<std::string>(),
               r["seconds_a_step"].get<double>(),
               r["solves"].get<double>() / r["steps"].get<double>(), r["worst"].get<double>(),
               r["mean"].get<double>(), r["drafts"].get<int64_t>());
}

int compare(const Wanted& wanted) {
  const std::string& file = wanted.scene;
  const char* words[] = {"elastogen", "simulate", "--scene", file.c_str()};
  const CommandLine line = parse_command_line(4, words);
  if (!line.animate) return line.code;
  const AnimateOptions& o = *line.animate;
  const Setup setup = set_up(read_tet_asset(o.input), o);
  const fem::FemScene scene = fem_scene(setup, o);
  const std::vector<Played> runs = runs_of(scene, o, wanted);
  print(result_of(scene, o, wanted, runs)["rows"]);
  return 0;
}

std::vector<double> numbers_of(const std::string& list) {
  std::vector<double> numbers;
  std::istringstream words(list);
  for (std::string word; std::getline(words, word, ',');) numbers.push_back(std::stod(word));
  return numbers;
}

Wanted wanted_of(int argc, char** argv) {
  Wanted wanted;
  for (int k = 1; k < argc; ++k) {
    const std::string word = argv[k];
    if (word == "--explicit") {
      wanted.with_explicit = true;
    } else if (!word.starts_with("--")) {
      wanted.scene = word;
    } else if (k + 1 < argc) {
      const std::string value = argv[++k];
      if (word == "--json") wanted.json = value;
      if (word == "--fine") wanted.fine = std::stod(value);
      if (word == "--implicit") wanted.implicit = numbers_of(value);
      if (word == "--explicit-dt") wanted.explicit_dt = std::stod(value);
      if (word == "--frames") wanted.frames = std::stoll(value);
      if (word == "--explicit-frames") wanted.explicit_frames = std::stoll(value);
    }
  }
  return wanted;
}

}  // namespace
}  // namespace elastogen::bench

int main(int argc, char** argv) {
  try {
    const elastogen::bench::Wanted wanted = elastogen::bench::wanted_of(argc, argv);
    if (wanted.scene.empty()) {
      fmt::print(
          stderr,
          "usage: bench_metal_frame SCENE.toml [--explicit] [--json FILE] [--fine DT]\n"
          "       [--implicit DT,DT] [--frames N] [--explicit-frames N] [--explicit-dt DT]\n");
      return 2;
    }
    return elastogen::bench::compare(wanted);
  } catch (const std::exception& error) {
    fmt::print(stderr, "bench_metal_frame: {}\n", error.what());
    return 1;
  }
}
