// SPDX-License-Identifier: Apache-2.0
#include "cli/bench_options.hpp"

#include "core/error.hpp"

#include <CLI/CLI.hpp>

#include <algorithm>

namespace elastogen {
namespace {

/// @throws Error unless each of the values lies in a range.
void check(const char* option, const std::vector<double>& values, double lower, double upper) {
  for (const double value : values)
    ELASTOGEN_CHECK(value >= lower && value <= upper, option, " must lie in ", lower, " ... ",
                    upper, ", got ", value);
}

/// @throws Error naming the known names for any other.
void check(const char* option, const std::vector<std::string>& names,
           const std::vector<std::string>& known) {
  for (const std::string& name : names)
    ELASTOGEN_CHECK(std::find(known.begin(), known.end(), name) != known.end(), option, ": '", name,
                    "' is not known; known are ", CLI::detail::join(known, ", "));
}

}  // namespace

void BenchOptions::add_axes(CLI::App& verb) {
  bench::BenchTask& task = verb_.task;
  const auto add = [&](const char* name, auto& values, const char* text) {
    verb.add_option(name, values, text)->delimiter(',')->capture_default_str();
  };
  add("--scenes", task.scenes, "kernels, step, error-time: beam, ball, c84");
  add("--sizes", task.sizes, "voxels, or particles, like 3.2e4,1e6; default by part and device");
  add("--courant", task.courants, "(dt/h) sqrt(E/rho)");
  add("--poisson", task.poissons, "Poisson's ratios");
  add("--fill", task.fills, "step, error-time, beam: shares of the box that are solid, 0.01 to 1");
  add("--solvers", solvers_, "error-time: quasi, newton, paper");
  add("--integrators", task.integrators, "particles: explicit, implicit");
  add("--tolerances", task.tolerances, "error-time");
  verb.add_option("--tolerance", task.tolerance, "step, tip, baseline: of the residual")
      ->capture_default_str();
  verb.add_flag("--fem", task.fem, "tip: by quadratic tetrahedra, six in a voxel");
  verb.add_option("--repeat", task.repeats, "runs of each time; 0: those of the part")
      ->capture_default_str();
}

void BenchOptions::add_baseline(CLI::App& verb) {
  bench::BenchTask& task = verb_.task;
  task.python = "python3";
  verb.add_option("--python", task.python, "baseline: program with PyTorch")->capture_default_str();
  verb.add_option("--script", task.script, "baseline: elsewhere than in the sources");
  verb.add_option("--runs", task.runs,
                  "baseline: eager, compile, graph (CUDA) or numpy, and library or jacobi for the "
                  "decomposition")
      ->delimiter(',')
      ->capture_default_str();
  verb.add_option("--outer", task.loops.outer, "baseline: loops a step")->capture_default_str();
  verb.add_option("--inner", task.loops.inner, "sweeps of each loop")->capture_default_str();
  verb.add_option("--modes", task.loops.modes, "latent size, three times the cosines")
      ->capture_default_str();
}

void BenchOptions::add(CLI::App& app, const std::string& command) {
  verb_.command = command;
  CLI::App* verb = app.add_subcommand("bench", "measures the machine and the solvers on it");
  verb->add_option(
          "PART", verb_.task.parts,
          "ceilings, kernels, step, error-time, tip, baseline, particles, startup; several are run "
          "in turn")
      ->required();
  verb->add_option("--device", device_, "auto, cpu or cuda")->capture_default_str();
  verb->add_option("--json", verb_.json, "what was measured, on what");
  verb->add_option("--threads", verb_.threads, "0: all")->capture_default_str();
  add_axes(*verb);
  add_baseline(*verb);
  app_ = verb;
}

bool BenchOptions::parsed() const {
  return app_->parsed();
}

BenchVerb BenchOptions::take() const {
  BenchVerb verb = verb_;
  bench::BenchTask& task = verb.task;
  check("PART", task.parts, bench::part_names());
  check("--device", std::vector{device_}, {"auto", "cpu", "cuda"});
  task.device = device_ == "auto" ? Device::kAuto : device_ == "cpu" ? Device::kCpu : Device::kCuda;
  check("--scenes", task.scenes, {"beam", "ball", "c84"});
  check("--solvers", solvers_, {"quasi", "newton", "paper"});
  task.solvers.clear();
  for (const std::string& name : solvers_) task.solvers.push_back(solver_from_name(name));
  check("--runs", task.runs,
        {"eager-library", "eager-jacobi", "compile-library", "compile-jacobi", "graph-library",
         "graph-jacobi", "numpy-library", "numpy-jacobi"});
  check("--integrators", task.integrators, {"explicit", "implicit"});
  check("--sizes", task.sizes, 1, 1e8);
  check("--courant", task.courants, 1e-3, 1e4);
  check("--poisson", task.poissons, 0, 0.499);
  check("--fill", task.fills, 0.01, 1);
  check("--tolerances", task.tolerances, 1e-12, 1);
  check("--tolerance", {task.tolerance}, 1e-12, 1);
  check("--repeat", {double(task.repeats)}, 0, 1e6);
  return verb;
}

}  // namespace elastogen
