// SPDX-License-Identifier: Apache-2.0
// The command line as option structs; units are converted here.

#pragma once

#include "cli/batch_task.hpp"
#include "cli/bench_options.hpp"
#include "cli/materials_options.hpp"
#include "cli/picture/picture_options.hpp"
#include "cli/train_options.hpp"
#include "scene/description.hpp"

#include <optional>
#include <string>
#include <vector>

namespace elastogen {

/// A run, and what the command itself does about it.
struct AnimateOptions : RunDescription {
  PictureOptions picture;  ///< of .png
  bool strict = false;     ///< warnings are errors
  bool quiet = false;
  bool print_resolved = false;  ///< the scene that results, instead of the run
};

/// Whether it names an asset or a shape.
inline bool has_body(const AnimateOptions& o) {
  return !o.input.empty() || o.shape;
}

struct VoxelizeTask {
  AnimateOptions scene;  ///< input, resolution, limits, report
  std::string output;    ///< .vdb
};

struct InspectTask {
  AnimateOptions scene;
  bool is_scene = false;  ///< the file was a scene, not an asset
  bool json = false;
  bool schema = false;  ///< print the schema of scene files instead
};

struct DoctorTask {
  AnimateOptions scene;
  bool json = false;
};

struct StudyTask {
  AnimateOptions scene;
  std::string folder = "study";  ///< of study.json, .csv, .html and the PVD files
  int repeats = 3;               ///< of each run, for its time
  std::vector<SolverMode> solvers = {SolverMode::kQuasi, SolverMode::kNewton, SolverMode::kPaper};
  std::vector<double> tolerances = {1e-1, 1e-2, 1e-3, 1e-4, 1e-5};  ///< of quasi and newton
  fem::Element reference = fem::Element::kHexBbar;                  ///< of discretisation errors
  int refine = 2;  ///< its grid has voxels of h / refine; 0: no such errors
  std::vector<int> resolutions = {4, 2, 1};    ///< h of the sweep over that of the reference
  std::vector<int> time_steps = {1, 2, 4, 8};  ///< dt over that of the sweep; one: no sweep
  std::vector<double> explicit_dts;            ///< of particles with a transfer after each step [s]
  bool noise_floor = true;  ///< of particles: the reference also with four times the substeps
};

struct DemoOptions {
  std::string folder = ".";
  int threads = 0;
  bool quiet = false;
  std::string command;
};

/// What was asked for: at most one verb is set; with none, `code` is the exit code (help, version,
/// usage errors, which have been printed).
struct CommandLine {
  std::optional<AnimateOptions> animate;  ///< and simulate, where fem is set
  std::optional<BatchTask> batch;         ///< animate --batch
  std::optional<DemoOptions> demo;
  std::optional<VoxelizeTask> voxelize;
  std::optional<InspectTask> inspect;
  std::optional<DoctorTask> doctor;
  std::optional<MaterialsTask> materials;
  std::optional<StudyTask> study;
  std::optional<TrainVerb> train;
  std::optional<BenchVerb> bench;
  int code = 0;
};

/// A scene file fills in what is not on the command line.
/// @throws Error (usage) on values that are no numbers, units, materials or selections, and on
///         scene files as read_scene.
CommandLine parse_command_line(int argc, const char* const* argv);

}  // namespace elastogen
