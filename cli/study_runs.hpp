// SPDX-License-Identifier: Apache-2.0
// The runs of a study and their evaluation (docs/study.md).

#pragma once

#include "cli/options.hpp"
#include "cli/study_compare.hpp"
#include "scene/set_up.hpp"

namespace elastogen {

/// A grid of the scene with one time step.
struct StudyStage {
  Setup setup;
  int64_t steps = 0;
};

/// A run with which others are compared.
struct Reference {
  std::string name;
  Trajectory run;
};

/// A signal came; the run that it interrupted does not count.
struct StudyInterrupted {};

class Study {
 public:
  /// Reads and voxelises the asset. @throws Error as read_asset and set_up.
  explicit Study(const StudyTask& task);

  /// Makes all runs, prints their names, writes the PVD files; a signal ends it early.
  /// @throws Error as make_stepper.
  StudyResult run();

 private:
  StudyStage make_stage(const AnimateOptions& options) const;
  AnimateOptions fem_options(fem::Element element) const;
  AnimateOptions network_options(SolverMode mode, double tolerance) const;

  StudyRun& add_run(const std::string& name, const StudyStage& stage, const AnimateOptions& options,
                    Trajectory* kept);
  void take_energies(const Trajectory& trajectory, StudyRun& run) const;
  StudyErrors solver_errors(const StudyStage& stage, const AnimateOptions& options,
                            const Trajectory& run, const Reference& reference) const;
  StudyErrors grid_errors(const StudyStage& stage, const Trajectory& run) const;

  void take_runs();
  void compare_solvers();
  void compare_paper();
  void compare_elements();
  void add_element(fem::Element element);
  void sweep_tolerance();
  void sweep_resolution();
  void sweep_time_step();

  void add_overlay(const std::string& name, const StudyStage& stage, const Trajectory& run);
  void write_pvd(const std::string& name, const StudyStage& stage, const Trajectory& run) const;

  const StudyTask& task_;
  Asset asset_;
  StudyStage stage_;                // the grid of the scene
  std::optional<StudyStage> fine_;  // grid of the reference of discretisation errors
  Reference solver_reference_, grid_reference_;
  double reference_change_ = 0;  // change of grid_reference_ from the grid of the scene
  StudyResult result_;
};

}  // namespace elastogen
