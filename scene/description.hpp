// SPDX-License-Identifier: Apache-2.0
// What a run is, in values: filled by the options of the command, by scene files, or by a program
// that uses the library.

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

/// An axis-parallel floor; without a place it is the lowest point of the asset along up.
struct FloorPlane {
  int axis = -1;                ///< -1: the up axis
  std::optional<double> place;  ///< [m]
};

/// Finite elements in place of the network.
struct FemOptions {
  fem::Element element = fem::Element::kVoxel;
  /// The element was asked for; else tetrahedra of a file keep their kind, and voxels of which
  /// some yield are hex, of metals that harden hex-bbar.
  bool named = false;
  fem::Mass mass = fem::Mass::kLumped;
  bool any_rounding = false;  ///< the tolerance rises above the rounding of doubles
  bool newmark = false;       ///< instead of the time scheme
  bool resolution = false;    ///< a resolution was asked for: tetrahedra of a file have their own
  bool statics = false;       ///< an equilibrium instead of time steps: one frame, one step of 1 s
};

/// What steps a body that yields: elements or particles; auto: particles where a material falls
/// apart into grains (is_granular), else elements.
enum class Method : uint8_t { kAuto, kMpm, kFem };

/// What takes the steps of particles: implicit Euler, symplectic Euler, or implicit Euler by passes of
/// minima with the plastic part frozen, until they solve it or as PlasticityNet has them.
enum class Integrator : uint8_t { kImplicit, kExplicit, kFrozenFixedPoint, kPnFixedPoint };

/// Particles in place of the grid.
struct ParticleOptions {
  Integrator integrator = Integrator::kImplicit;
  double dt = 0;      ///< from one transfer to the next [s], 0: by their speed, or that of waves
  int substeps = 1;   ///< of explicit steps between two transfers, on nodes that stay
  int passes = 3;     ///< of kPnFixedPoint
  int per_edge = 2;   ///< of a full voxel along an axis
  double jitter = 1;  ///< as mpm::FillOptions
  mpm::TransferOptions transfer;
};

/// What gives the stress of a material: its law, its net, or its net where one keeps the limits.
enum class EnergySource : uint8_t { kAuto, kAnalytic, kNeural };

struct RunDescription {
  // the asset and its grid
  std::string input;               ///< file
  std::optional<BodyShape> shape;  ///< in place of a file
  ReadOptions read;                ///< what the file does not say itself
  double size = 0;                 ///< longest edge of the asset [m], 0: as the file has it
  std::optional<UpAxis> up;        ///< unset: as the file has it, else a guess
  int voxels = 48;                 ///< along the longest edge
  double h = 0;                    ///< voxel edge [m], 0: from voxels
  bool part_pieces = false;        ///< pieces that do not touch are not joined
  double thickness = 0;            ///< of sheets and shells [m], 0: that of a voxel

  // what it is made of
  Material material;                    ///< of what no region takes
  Yield yield = {};                     ///< of that material
  std::vector<MaterialRegion> regions;  ///< later ones on top of earlier ones
  /// Materials, and the one of each voxel, (voxels, 1), in place of `material`; empty: that one.
  std::vector<Material> materials;
  std::function<Array<int32_t>(const VoxelGrid&)> material_of;

  // what acts on it
  std::vector<Pin> pins;
  std::vector<Hold> holds;  ///< finite elements only, so are the next two
  std::vector<Traction> tractions;
  std::vector<Move> moves;
  std::vector<Obstacle> colliders;
  std::optional<FloorPlane> floor;
  double friction = 0.5;        ///< of the floor, and of colliders that name none; kSticks: sticky
  std::optional<Vec3> gravity;  ///< [m/s^2]; unset: 9.81 down
  StartMotion motion;

  // time and solver
  int64_t frames = 120;  ///< after the first
  double fps = 30;
  int substeps = 0;  ///< 0: by the Courant number
  TimeScheme scheme = TimeScheme::kEuler;
  SolverOptions solver{.device = Device::kAuto};
  std::optional<FemOptions> fem;  ///< set: finite elements take the steps
  Method method = Method::kAuto;  ///< of a run with a material that yields
  ParticleOptions particles;
  EnergySource energy = EnergySource::kAuto;
  Hourglass hourglass = Hourglass::kFull;

  // what is written
  std::vector<std::string> outputs;  ///< animations, each by its ending
  bool keyframe = false;             ///< GLB profile; else modal
  int glb_targets = 64;              ///< most morph targets of a mesh of a GLB
  bool glb_colliders = false;        ///< floor and colliders stand in the GLB
  std::string state, log, report;    ///< files, empty for none
  std::string command;               ///< what the outputs say made them

  // limits
  int threads = 0;         ///< 0: all
  int64_t max_memory = 0;  ///< [bytes], 0: no limit
  int64_t max_voxels = 64'000'000;
  double max_time = 0;  ///< wall time of the steps [s], 0: no limit
};

/// Whether a material of the run yields, and the method that this leaves; kAuto: none yields.
Method method_of(const RunDescription& run);

}  // namespace elastogen
