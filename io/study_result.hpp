// SPDX-License-Identifier: Apache-2.0
// The result of `elastogen study`: one scene run by several solvers on several elements, with the
// cost of each run and its error against its reference. There are two families of errors, which are
// never mixed: the error of the solver, against a tight solution on its own grid, and the error of
// the grid, against a converged mesh of another element. docs/study.md has the definitions.

#pragma once

#include "io/outline.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace elastogen {

struct StudyMachine {
  std::string cpu;  ///< model
  int64_t cores = 0;
  int64_t memory_bytes = 0;
  double copy_bandwidth = 0;  ///< bytes read and written by a parallel copy [B/s]
};

struct StudyHeader {
  std::string scene;       ///< name
  std::string scene_text;  ///< all keys with their values
  std::string command;     ///< as it was typed
  std::string commit;      ///< of the build
  std::string date;        ///< ISO 8601
  int64_t threads = 0;
  int64_t repeats = 0;  ///< runs for each time
  StudyMachine machine;
};

/// Wall time of the run over its steps, quartiles of the repeats [ms].
struct StepTime {
  double lower_quartile = 0, median = 0, upper_quartile = 0;
};

/// Fixed numbers of iterations, for a run that does not stop at a tolerance.
struct LoopBudget {
  int64_t outer = 0, inner = 0;
  int64_t modes = 0;  ///< latent size of the encoder
};

/// Energies at the end of each step [J], all of one length.
struct EnergySeries {
  std::vector<double> kinetic, elastic, hourglass, gravity, contact, total;
};

struct ErrorSeries {
  std::vector<double> steps;  ///< at the end of each step [-]
  double max = 0;             ///< largest of the steps, inf for a run that broke off [-]
};

/// Errors of a run against another one.
struct StudyErrors {
  std::string reference;    ///< name of the other run
  ErrorSeries step;         ///< each step started from the reference's state
  ErrorSeries free_run;     ///< the run on its own
  double iou = 0;           ///< volume of the common part over that of the union, last frame [-]
  double energy_drift = 0;  ///< of total energies, over the reference's largest kinetic one [-]
  /// free_run of the reference's own element on the grid before its last refinement [-]. An error
  /// below it cannot be ascribed to the run. Only for discretisation errors.
  std::optional<double> reference_change = {};
};

struct StudyRun {
  std::string name;                 ///< unique in the study
  std::string solver;               ///< "quasi", "newton", "paper" or "fem"
  std::string element;              ///< "voxel", "hex", "hex-bbar", "tet4", "tet10", ...
  double h = 0;                     ///< edge of voxels or elements [m]
  double dt = 0;                    ///< time step [s]
  std::optional<double> tolerance;  ///< of the residual [-]
  std::optional<LoopBudget> loops;
  int64_t steps = 0;     ///< number of time steps
  int64_t voxels = 0;    ///< voxels of the grid, 0 without one
  int64_t elements = 0;  ///< of the mesh
  int64_t dofs = 0;      ///< free displacement components
  StepTime step_ms;
  int64_t state_bytes = 0;             ///< of positions and velocities
  double state_copies_per_second = 0;  ///< copies of state_bytes, measured beside the run [1/s]
  int64_t outer = 0, inner = 0;        ///< iterations of the whole run
  double converged_share = 0;          ///< of the steps, 0 ... 1
  double worst_residual = 0;           ///< largest of all steps [-]
  double min_j = 1;                    ///< smallest det F of all steps
  std::vector<double> residual;        ///< of each step [-]
  EnergySeries energy;
  std::optional<StudyErrors> solver_error;  ///< against this grid, solved to a tight tolerance
  std::optional<StudyErrors> discretisation_error;  ///< against a converged mesh of another element
};

enum class ErrorFamily { kSolver, kDiscretisation };
enum class ErrorMeasure { kStep, kFreeRun };

/// The fastest run below an error; no name and no time if no run reached it.
struct ReachedError {
  double error = 0;               ///< [-]
  std::string run = {};           ///< name
  std::optional<double> ms = {};  ///< median time of a step [ms]
};

/// Time that a solver needs for an error. Only runs against one reference are compared.
struct TimeToError {
  ErrorFamily family = ErrorFamily::kSolver;
  ErrorMeasure measure = ErrorMeasure::kStep;
  std::string reference;
  std::string solver;
  std::vector<ReachedError> levels;  ///< 1e-1, 1e-2, 1e-3, 1e-4
};

/// Largest error over a varied quantity.
struct StudySweep {
  std::string name;      ///< of the line in the plot
  std::string variable;  ///< "h", "dt", "tolerance", ...
  std::string unit;      ///< of the variable: "m", "s", "-"
  ErrorFamily family = ErrorFamily::kSolver;
  ErrorMeasure measure = ErrorMeasure::kFreeRun;
  std::vector<double> x;      ///< values of the variable
  std::vector<double> error;  ///< error at each [-]
  double order = 0;           ///< by observed_order, NaN if there is none
};

/// Outlines of several runs at one time, in a plane.
struct ShapeOverlay {
  std::string title;
  double time = 0;                   ///< [s]
  std::string horizontal, vertical;  ///< names of the axes
  std::vector<Outline> outlines;
};

/// A number with a known value.
struct StudyFigure {
  std::string name;
  double value = 0, reference = 0;
  double tolerance = 0;  ///< largest difference allowed, in that unit
  std::string unit;      ///< of all three
  bool pass = false;
};

struct StudyResult {
  StudyHeader header;
  std::vector<StudyRun> runs;
  std::vector<TimeToError> time_to_error;  ///< by times_to_error(runs)
  std::vector<StudySweep> sweeps;
  std::vector<ShapeOverlay> overlays;
  std::vector<StudyFigure> figures;
};

}  // namespace elastogen
