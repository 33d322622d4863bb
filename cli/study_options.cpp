// SPDX-License-Identifier: Apache-2.0
#include "cli/study_options.hpp"

#include "core/error.hpp"
#include "io/units.hpp"

#include <CLI/CLI.hpp>

namespace elastogen {

void add_study_options(CLI::App& app, StudyTask& task, StudyNames& names) {
  // output and repeats
  app.add_option("--folder", task.folder, "of study.json, study.csv, study.html, .pvd")
      ->capture_default_str();
  app.add_option("--repeat", task.repeats, "runs of each kind, for their time")
      ->capture_default_str();
  // runs of the network, against their own grid
  app.add_option("--solvers", names.solvers, "of the network: quasi, newton, paper")
      ->delimiter(',')
      ->capture_default_str();
  app.add_option("--tolerances", task.tolerances, "of quasi and newton")
      ->delimiter(',')
      ->capture_default_str();
  // the reference of discretisation errors, and the sweeps
  app.add_option("--reference", names.reference,
                 "element of the reference of discretisation errors")
      ->capture_default_str();
  app.add_option("--refine", task.refine, "its voxels are h over this; 0: no discretisation errors")
      ->capture_default_str();
  app.add_option("--resolutions", task.resolutions, "h of the sweep over that of the reference")
      ->delimiter(',')
      ->capture_default_str();
  app.add_option("--time-steps", task.time_steps, "dt over those of the sweep; 1: no sweep")
      ->delimiter(',')
      ->capture_default_str();
  // particles
  app.add_option("--explicit-dt", names.explicit_dts,
                 "particles: steps with a transfer after each, e.g. '10 us', or none")
      ->delimiter(',')
      ->capture_default_str();
  app.add_flag("--noise-floor,!--no-noise-floor", task.noise_floor,
               "particles: the reference also with four times the substeps");
}

void resolve_study(const StudyNames& names, StudyTask& task) {
  // names
  task.reference = fem::element_from_name(names.reference);
  task.solvers.clear();
  for (const std::string& name : names.solvers) {
    task.solvers.push_back(solver_from_name(name));
    ELASTOGEN_CHECK(task.solvers.back() != SolverMode::kAuto,
                    "--solvers: auto is one of the others; name quasi, newton or paper");
  }
  // ranges
  for (const double tolerance : task.tolerances)
    ELASTOGEN_CHECK(tolerance > 0 && tolerance < 1, "--tolerances must lie between 0 and 1, got ",
                    tolerance);
  ELASTOGEN_CHECK(task.repeats >= 1 && task.repeats <= 1000,
                  "--repeat must lie in 1 ... 1000, got ", task.repeats);
  ELASTOGEN_CHECK(task.refine >= 0 && task.refine <= 16, "--refine must lie in 0 ... 16, got ",
                  task.refine);
  for (const int value : task.resolutions)
    ELASTOGEN_CHECK(value >= 1, "--resolutions must be 1 or more, got ", value);
  for (const int value : task.time_steps)
    ELASTOGEN_CHECK(value >= 1, "--time-steps must be 1 or more, got ", value);
  // explicit time steps, or none
  for (const std::string& text : names.explicit_dts) {
    if (text == "none") continue;
    task.explicit_dts.push_back(parse_time(text));
    ELASTOGEN_CHECK(task.explicit_dts.back() > 0, "--explicit-dt must be positive, got '", text,
                    "'");
  }
}

}  // namespace elastogen
