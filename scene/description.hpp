// SPDX-License-Identifier: Apache-2.0
// The values that describe a run. Options of the command, scene files or a program that uses the
// library fill them.

#pragma once

#include "core/scene.hpp"
#include "core/state.hpp"
#include "io/asset_pose.hpp"
#include "io/read_options.hpp"
#include "mpm_fem/fem_scene.hpp"
#include "mpm_fem/mpm/mpm_scene.hpp"
#include "network/solver.hpp"
#include "scene/boundary.hpp"
#include "scene/material_region.hpp"
#include "scene/obstacle.hpp"
#include "scene/shape.hpp"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace elastogen {

/// An axis-parallel floor; without a place it lies at the lowest point of the asset along up.
struct FloorPlane {
  int axis = -1;                ///< -1: the up axis
  std::optional<double> place;  ///< [m]
};

/// Finite elements in place of the network.
struct FemOptions {
  fem::Element element = fem::Element::kVoxel;
  /// Whether the element was asked for. If not, tetrahedra of a file keep their kind; voxels of
  /// which some yield become hex, or hex-bbar if all of them are metals that harden.
  bool named = false;
  fem::Mass mass = fem::Mass::kLumped;
  bool any_rounding = false;  ///< whether rounding of doubles may raise the tolerance
  bool newmark = false;       ///< Newmark's scheme in place of the time scheme
  bool resolution = false;  ///< a resolution was asked for, which tetrahedra of a file do not have
  bool statics = false;     ///< an equilibrium instead of time steps: one frame, one step of 1 s
};

/// How a body that yields is stepped: by elements or particles; auto: particles if a material falls
/// apart into grains (is_granular), else elements.
enum class Method : uint8_t { kAuto, kMpm, kFem };

/// Integrator of particles: implicit Euler, symplectic Euler, or implicit Euler by minimisations
/// with the plastic part frozen, until they solve the step or as often as PlasticityNet does.
enum class Integrator : uint8_t { kImplicit, kExplicit, kFrozenFixedPoint, kPnFixedPoint };

/// Particles in place of the grid.
struct ParticleOptions {
  Integrator integrator = Integrator::kImplicit;
  double dt = 0;      ///< between transfers [s], 0: by the speed of particles or waves
  int substeps = 1;   ///< explicit steps between two transfers, on unchanged nodes
  int passes = 3;     ///< minimisations in a step of kPnFixedPoint
  int per_edge = 2;   ///< particles of a full voxel along an axis
  double jitter = 1;  ///< as mpm::FillOptions
  mpm::TransferOptions transfer;
};

/// Source of a material's stress: its law, its net, or its net if there is one within the limits.
enum class EnergySource : uint8_t { kAuto, kAnalytic, kNeural };

struct RunDescription {
  // the asset and its grid
  std::string input;               ///< file
  std::optional<BodyShape> shape;  ///< in place of a file
  ReadOptions read;                ///< facts that the file does not state
  double size = 0;                 ///< longest edge of the asset [m], 0: as the file has it
  std::optional<UpAxis> up;        ///< unset: as the file has it, else a guess
  int voxels = 48;                 ///< along the longest edge
  double h = 0;                    ///< voxel edge [m], 0: from voxels
  bool part_pieces = false;        ///< pieces that do not touch are not joined
  double thickness = 0;            ///< of sheets and shells [m], 0: that of a voxel

  // what it is made of
  Material material;                    ///< of everything outside the regions
  Yield yield = {};                     ///< of that material
  std::vector<MaterialRegion> regions;  ///< later regions override earlier ones
  /// Materials, and the material of each voxel, (voxels, 1), in place of `material`, unless empty.
  std::vector<Material> materials;
  std::function<Array<int32_t>(const VoxelGrid&)> material_of;

  // what acts on it
  std::vector<Pin> pins;
  std::vector<Hold> holds;
  std::vector<Traction> tractions;
  std::vector<Force> forces;
  std::vector<Move> moves;
  std::string wind_text;  ///< as it was typed
  Path wind;              ///< velocity of the air [m/s]; empty: none
  std::vector<Obstacle> colliders;
  std::optional<FloorPlane> floor;
  double friction = 0.5;        ///< of the floor, and default of colliders; kSticks: sticky
  std::optional<Vec3> gravity;  ///< [m/s^2]; unset: 9.81 down
  StartMotion motion;

  // time and solver
  int64_t frames = 120;  ///< frames after the first
  double fps = 30;
  int substeps = 0;  ///< 0: by the Courant number
  TimeScheme scheme = TimeScheme::kEuler;
  SolverOptions solver{.device = Device::kAuto};
  std::optional<FemOptions> fem;  ///< if set, finite elements make the steps
  Method method = Method::kAuto;  ///< for a run with a material that yields
  ParticleOptions particles;
  bool mesh_error = true;  ///< estimate by how much frames are wrong because of the voxels' size
  EnergySource energy = EnergySource::kAuto;
  Hourglass hourglass = Hourglass::kFull;

  // what is written
  std::vector<std::string> outputs;  ///< animations, each by its ending
  bool keyframe = false;             ///< GLB profile; else modal
  int glb_targets = 64;              ///< most morph targets of a mesh of a GLB
  bool glb_colliders = false;        ///< the GLB shows floor and colliders
  std::string state, log, report;    ///< files, empty for none
  std::string command;               ///< command that outputs name as their origin

  // limits
  int threads = 0;         ///< 0: all
  int64_t max_memory = 0;  ///< [bytes], 0: no limit
  int64_t max_voxels = 64'000'000;
  double max_time = 0;  ///< wall time of the steps [s], 0: no limit
};

/// The method of a run in which a material yields; kAuto if none yields.
Method method_of(const RunDescription& run);

}  // namespace elastogen
