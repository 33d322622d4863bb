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

/// A run, and options of the command itself.
struct AnimateOptions : RunDescription {
  PictureOptions picture;    ///< for .png
  bool strict = false;       ///< warnings are errors
  bool strict_time = false;  ///< exit code 4 for frames above the time error
  bool quiet = false;
  bool print_resolved = false;  ///< print the resolved scene instead of running it
};

/// Whether the options name an asset or a shape.
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
  std::string folder = "study";  ///< folder of study.json, .csv, .html and the PVD files
  int repeats = 3;               ///< runs of each kind, for their time
  std::vector<SolverMode> solvers = {SolverMode::kQuasi, SolverMode::kNewton, SolverMode::kPaper};
  std::vector<double> tolerances = {1e-1, 1e-2, 1e-3, 1e-4, 1e-5};  ///< of quasi and newton
  fem::Element reference = fem::Element::kHexBbar;  ///< reference of discretisation errors
  int refine = 2;  ///< the reference has voxels of h / refine; 0: no such errors
  std::vector<int> resolutions = {4, 2, 1};    ///< h of the sweep over that of the reference
  std::vector<int> time_steps = {1, 2, 4, 8};  ///< dt over that of the sweep; one: no sweep
  std::vector<double> explicit_dts;  ///< dt of particles with a transfer after each step [s]
  bool noise_floor = true;  ///< particles: run the reference also with four times the substeps
};

struct DemoOptions {
  std::string folder = ".";
  int threads = 0;
  bool quiet = false;
  std::string command;
};

/// The parsed verb. At most one is set; if none is, `code` is the exit code (help, version and
/// usage errors have been printed).
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

/// Reads the command line. A scene file supplies options that are not on it.
/// @throws Error (usage) on values that are no numbers, units, materials or selections, and on
///         scene files as read_scene.
CommandLine parse_command_line(int argc, const char* const* argv);

}  // namespace elastogen
