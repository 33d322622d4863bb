// SPDX-License-Identifier: Apache-2.0
// The command line as option structs; units are converted here.

#pragma once

#include "cli/batch_task.hpp"
#include "cli/bench_options.hpp"
#include "cli/picture/picture_options.hpp"
#include "cli/train_options.hpp"
#include "core/scene.hpp"
#include "core/state.hpp"
#include "io/asset_pose.hpp"
#include "io/read_options.hpp"
#include "mpm_fem/fem_scene.hpp"
#include "network/solver.hpp"

#include <optional>
#include <string>
#include <vector>

namespace elastogen {

/// --floor: an axis-parallel plane; without a place the lowest point of the asset along up.
struct FloorOption {
  int axis = -1;                ///< -1: the up axis
  std::optional<double> place;  ///< [m]
};

/// What `simulate` puts in the place of the network.
struct FemOptions {
  fem::Element element = fem::Element::kVoxel;
  bool named = false;  ///< by --element; else tetrahedra of a file keep their kind
  fem::Mass mass = fem::Mass::kLumped;
  bool any_rounding = false;  ///< the tolerance rises above the rounding of doubles
  bool newmark = false;       ///< instead of the time scheme
  bool resolution = false;    ///< --voxels or --h was given: tetrahedra of a file have their own
  bool statics = false;       ///< an equilibrium instead of time steps: one frame, one step of 1 s
};

/// What gives the stress of a material: its law, its net, or its net where one keeps the limits.
enum class EnergySource : uint8_t { kAuto, kAnalytic, kNeural };

struct AnimateOptions {
  std::string input;
  std::vector<std::string> outputs;                  ///< animations, each by its ending
  Material material;                                 ///< of what no region takes
  std::vector<std::string> pins;                     ///< selections
  std::vector<std::string> regions;                  ///< as typed (cli/region_option.hpp)
  std::vector<std::string> colliders;                ///< as typed (cli/collider_option.hpp)
  std::vector<std::string> holds, tractions, moves;  ///< as typed (cli/boundary_option.hpp)
  std::optional<Vec3> gravity;                       ///< [m/s^2]; unset: 9.81 down
  StartMotion motion;
  std::optional<FloorOption> floor;
  double friction = 0.5;     ///< of the floor, and of colliders that name none
  int voxels = 48;           ///< along the longest edge
  double h = 0;              ///< [m], 0: from voxels
  bool part_pieces = false;  ///< pieces that do not touch are not joined
  double thickness = 0;      ///< of sheets and shells [m], 0: that of a voxel
  double size = 0;           ///< longest edge of the asset [m], 0: as the file has it
  ReadOptions read;          ///< what the file does not say itself
  std::optional<UpAxis> up;  ///< unset: as the file has it, else a guess
  int64_t frames = 120;
  double fps = 30;
  int substeps = 0;  ///< 0: auto
  TimeScheme scheme = TimeScheme::kEuler;
  SolverOptions solver{.device = Device::kAuto};
  std::optional<FemOptions> fem;  ///< set: finite elements take the steps
  EnergySource energy = EnergySource::kAuto;
  Hourglass hourglass = Hourglass::kFull;
  bool keyframe = false;           ///< GLB profile; else modal
  int glb_targets = 64;            ///< most morph targets of a mesh of a GLB
  bool glb_colliders = false;      ///< floor and colliders stand in the GLB
  PictureOptions picture;          ///< of .png
  std::string state, log, report;  ///< files, empty for none
  int threads = 0;                 ///< 0: all
  int64_t max_memory = 0;          ///< [bytes], 0: no limit
  int64_t max_voxels = 64'000'000;
  double max_time = 0;  ///< wall time of the steps [s], 0: no limit
  bool strict = false, quiet = false;
  bool print_resolved = false;  ///< the scene that results, instead of the run
  std::string command;          ///< as typed
};

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

/// The task of `elastogen materials`.
struct MaterialsTask {
  enum class Action { kList, kShow, kReport, kGenerate, kFit };
  Action action = Action::kList;
  std::string name;               ///< preset, law, sum of laws or file that it is about
  std::optional<double> poisson;  ///< unset: the preset's, or the verb's own
  std::vector<std::string> laws;  ///< to fit; none: all
  std::string output;
  bool json = false;
  std::string command;  ///< as typed
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
