// SPDX-License-Identifier: Apache-2.0
// The runs of a study.
#include "cli/scene_options.hpp"
#include "cli/study_machine.hpp"
#include "cli/study_runs.hpp"
#include "io/scene_file.hpp"
#include "io/study_errors.hpp"
#include "scene/version.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

namespace elastogen {
namespace {

constexpr int kPaperOuter[] = {1, 3, 5, 20, 50};

/// Every k-th state and report of a run.
Trajectory thinned(const Trajectory& run, size_t k) {
  Trajectory result{{run.states[0]}, {}, run.broke_off};
  for (size_t n = k; n < run.states.size(); n += k) {
    result.states.push_back(run.states[n]);
    result.reports.push_back(run.reports[n - 1]);
  }
  return result;
}

}  // namespace

/// Compares the network's modes at several tolerances with a tight solution on the same element.
void Study::compare_solvers() {
  solver_reference_.name = "fem voxel";
  add_run(solver_reference_.name, stage_, fem_options(fem::Element::kVoxel),
          &solver_reference_.run);
  add_overlay(solver_reference_.name, stage_, solver_reference_.run);
  write_pvd("fem", stage_, solver_reference_.run);
  bool shown = false;  // whether a run of the network is in the overlay and the PVD files
  for (const SolverMode mode : task_.solvers)
    for (const double tolerance : task_.tolerances) {
      if (mode == SolverMode::kPaper) continue;
      const AnimateOptions options = network_options(mode, tolerance);
      Trajectory run;
      StudyRun& entry =
          add_run(fmt::format("{} {:.0e}", solver_name(mode), tolerance), stage_, options, &run);
      entry.solver_error = solver_errors(stage_, options, run, solver_reference_);
      if (shown || tolerance > task_.scene.solver.tolerance) continue;
      shown = true;
      add_overlay(entry.name, stage_, run);
      write_pvd("network", stage_, run);
    }
}

/// The published algorithm has no torsion correction, so it is compared with its own element.
void Study::compare_paper() {
  AnimateOptions scene = task_.scene;
  if (scene.hourglass == Hourglass::kFull) scene.hourglass = Hourglass::kVariance;
  const StudyStage stage = make_stage(scene);
  Reference reference{"fem voxel, variance", {}};
  AnimateOptions fem = fem_options(fem::Element::kVoxel);
  add_run(reference.name, stage, fem, &reference.run);
  for (const int outer : kPaperOuter) {
    AnimateOptions options = network_options(SolverMode::kPaper, task_.scene.solver.tolerance);
    options.solver.paper.outer = outer;
    Trajectory run;
    StudyRun& entry = add_run(fmt::format("paper {}x{}", outer, options.solver.paper.inner), stage,
                              options, &run);
    entry.solver_error = solver_errors(stage, options, run, reference);
  }
}

/// Runs an element on the voxels of the scene.
void Study::add_element(fem::Element element) {
  Trajectory run;
  StudyRun& entry = add_run(fmt::format("fem {}", fem::element_name(element)), stage_,
                            fem_options(element), &run);
  // how much refining changed the reference's own element bounds the reference's error
  if (element == task_.reference)
    reference_change_ =
        errors_between(stage_.setup.scene, run, fine_->setup.scene, grid_reference_.run).max;
  entry.discretisation_error = grid_errors(stage_, run);
}

/// Compares elements on the voxels of the scene, the reference's own first, with the reference on a
/// finer grid.
void Study::compare_elements() {
  AnimateOptions fine = task_.scene;
  fine.h = stage_.setup.scene.grid.h / task_.refine;
  fine_ = make_stage(fine);
  grid_reference_.name =
      fmt::format("fem {} h/{}", fem::element_name(task_.reference), task_.refine);
  add_run(grid_reference_.name, *fine_, fem_options(task_.reference), &grid_reference_.run);
  add_overlay(grid_reference_.name, *fine_, grid_reference_.run);
  const bool is_voxel = task_.reference == fem::Element::kVoxel;
  if (is_voxel)
    reference_change_ = errors_between(stage_.setup.scene, solver_reference_.run,
                                       fine_->setup.scene, grid_reference_.run)
                            .max;
  else
    add_element(task_.reference);
  for (StudyRun& run : result_.runs)
    if (run.name == solver_reference_.name)
      run.discretisation_error = grid_errors(stage_, solver_reference_.run);
  for (const fem::Element element :
       {fem::Element::kHex, fem::Element::kHexBbar, fem::Element::kTet4, fem::Element::kTet10})
    if (element != task_.reference) add_element(element);
}

void Study::sweep_tolerance() {
  for (const char* solver : {"quasi", "newton"}) {
    StudySweep sweep{.name = solver,
                     .variable = "tolerance",
                     .unit = "-",
                     .family = ErrorFamily::kSolver,
                     .measure = ErrorMeasure::kStep,
                     .x = {},
                     .error = {},
                     .order = 0};
    for (const StudyRun& run : result_.runs)
      if (run.solver == solver && run.solver_error && run.tolerance) {
        sweep.x.push_back(*run.tolerance);
        sweep.error.push_back(run.solver_error->step.max);
      }
    sweep.order = observed_order(sweep.x, sweep.error);
    if (!sweep.x.empty()) result_.sweeps.push_back(std::move(sweep));
  }
}

/// Compares the network on coarser and finer grids with the reference of discretisation errors.
void Study::sweep_resolution() {
  StudySweep sweep{.name = "newton, voxel",
                   .variable = "h",
                   .unit = "m",
                   .family = ErrorFamily::kDiscretisation,
                   .measure = ErrorMeasure::kFreeRun,
                   .x = {},
                   .error = {},
                   .order = 0};
  for (const int divisor : task_.resolutions) {
    AnimateOptions options = network_options(SolverMode::kNewton, 1e-4);
    options.h = fine_->setup.scene.grid.h * divisor;
    const StudyStage stage = make_stage(options);
    Trajectory run;
    StudyRun& entry = add_run(fmt::format("newton h={:.3g}", options.h), stage, options, &run);
    entry.discretisation_error = grid_errors(stage, run);
    sweep.x.push_back(options.h);
    sweep.error.push_back(entry.discretisation_error->free_run.max);
  }
  sweep.order = observed_order(sweep.x, sweep.error);
  result_.sweeps.push_back(std::move(sweep));
}

/// Newton on one grid with dt, dt/2, ..., each run compared with the next. The slope is then the
/// order of the time scheme, whatever limit the runs converge to.
void Study::sweep_time_step() {
  StudySweep sweep{.name = "newton, to the next dt",
                   .variable = "dt",
                   .unit = "s",
                   .family = ErrorFamily::kSolver,
                   .measure = ErrorMeasure::kFreeRun,
                   .x = {},
                   .error = {},
                   .order = 0};
  // each run against the one before it, at the times of that one
  std::optional<Trajectory> before;
  for (const int divisor : task_.time_steps) {
    AnimateOptions options = network_options(SolverMode::kNewton, 1e-6);
    options.substeps = stage_.setup.substeps * divisor;
    const StudyStage stage = make_stage(options);
    Trajectory run;
    add_run(fmt::format("newton dt={:.3g}", stage.setup.scene.dt), stage, options, &run);
    run = thinned(run, size_t(divisor));
    if (before) sweep.error.push_back(free_run_errors(stage.setup.scene, *before, run).max);
    sweep.x.push_back(stage.setup.scene.dt);
    before = std::move(run);
  }
  // the last run has none to compare with
  sweep.x.pop_back();
  sweep.order = observed_order(sweep.x, sweep.error);
  result_.sweeps.push_back(std::move(sweep));
}

StudyResult Study::run() {
  StudyHeader& header = result_.header;
  header.scene = std::filesystem::path(task_.scene.input).filename().string();
  header.scene_text = scene_json(resolved_scene(task_.scene));
  header.command = task_.scene.command;
  header.commit = build_commit();
  header.date = utc_date();
  header.machine = this_machine();
  header.threads = task_.scene.threads > 0 ? task_.scene.threads : header.machine.cores;
  header.repeats = task_.repeats;
  try {
    take_runs();
  } catch (const StudyInterrupted&) {
    // return the runs so far
  }
  result_.time_to_error = times_to_error(result_.runs);
  return std::move(result_);
}

void Study::take_runs() {
  compare_solvers();
  if (task_.tolerances.size() > 1) sweep_tolerance();
  if (std::count(task_.solvers.begin(), task_.solvers.end(), SolverMode::kPaper)) compare_paper();
  if (task_.refine > 0) {
    compare_elements();
    sweep_resolution();
  }
  if (task_.time_steps.size() > 1) sweep_time_step();
}

}  // namespace elastogen
