// SPDX-License-Identifier: Apache-2.0
// The input of a solver: grid, materials, constraints, forces, colliders, time step.

#pragma once

#include "core/collider.hpp"
#include "core/dependent_nodes.hpp"
#include "core/holder.hpp"
#include "core/loads.hpp"
#include "core/material.hpp"
#include "core/voxel_grid.hpp"

#include <vector>

namespace elastogen {

/// Euler, bdf2: one scheme with steps of dt. sdirk2: two stages a step of dt. auto: within each dt as
/// many steps as the time error asks for, bdf2 for one of them and sdirk2 for more
/// (core/time_control.hpp); a step reports which of them it was.
enum class TimeScheme : uint8_t { kEuler = 0, kBdf2 = 1, kSdirk2 = 2, kAuto = 3 };

/// Whether the motion is taken relative to a rigid reference, in stages (core/time_stage.hpp).
constexpr bool has_stages(TimeScheme scheme) {
  return scheme == TimeScheme::kSdirk2 || scheme == TimeScheme::kAuto;
}

/// Which part of the strain-variance (hourglass) term acts: with the corotated torsion correction,
/// plain, or none (the operator that the ElastoGen paper prints).
enum class Hourglass { kFull, kVariance, kOff };

/// Points of the asset's surface, each carried by the trilinear weights of a voxel.
/// Filled by voxelize/surface_points; needed only where there is a collider.
struct SurfacePoints {
  Array<int32_t> voxel;    ///< (points, 1)
  Array<double> weights;   ///< trilinear weight of each corner, (points, 8), rows sum to 1
  Array<double> area;      ///< share of the surface [m^2], (points, 1)
  Array<double> position;  ///< at rest [m], (points, 3)
};

struct Scene {
  VoxelGrid grid;
  Vec3 place = {};  ///< of the scene's zero in the asset's coordinates [m]: files hold the sum
  std::vector<Material> materials = {Material{}};
  Array<int32_t> material;   ///< index into materials of each voxel, (voxels, 1)
  Array<uint8_t> pinned;     ///< NodeKind: 1 where a node keeps its position, 2 where it follows
                             ///< others, (nodes, 1)
  DependentNodes dependent;  ///< those that follow others; the solver `paper` has none
  std::vector<Holder> holders;
  Array<int32_t> holder;  ///< of each node in `holders`, -1 if it is free, (nodes, 1); empty: held
                          ///< nodes rest
  Array<int32_t> fixed;   ///< holder of each component of u that stays 0 at a free node, else -1,
                          ///< (nodes, 3); empty: none
  Array<double> load;     ///< dead load on each node [N], (nodes, 3); empty: none
  std::vector<TimedForce> forces;
  Wind wind;
  Vec3 gravity = {};  ///< [m/s^2]
  std::vector<Collider> colliders;
  double impact_speed = 0;  ///< at which colliders may be met [m/s]: contact_young
  SurfacePoints surface;
  double dt = 1.0 / 60;  ///< [s]
  TimeScheme scheme = TimeScheme::kEuler;
  Hourglass hourglass = Hourglass::kFull;

  // filled by finish_scene
  Array<double> mass;      ///< lumped mass of each node [kg], (nodes, 1)
  Array<double> variance;  ///< hourglass weight of the patterns xy, yz, zx, xyz before the fill
                           ///< [Pa], (voxels, 4)
};

/// Fills mass and variance of a scene:
///
///     m_c = sum over the voxels of c of s rho phi h^3 Nbar_c,
///
/// s scales each material so that, where the asset has a volume, the total mass is exact;
/// variance weights (mu + E/2)/2, E/(2(1-nu^2)) in sheets and E/2 in strips one voxel thick, there
/// times phi^2 on the patterns that contain a thin axis (notes in docs/physics.md); (t/h)^2 where
/// the voxel holds a sheet of thickness t.
///
/// @throws Error on inconsistent shapes, indices out of range, a bad material, a fill, dt or mass
///         that is not positive, or numbers that are not finite, with their place.
void finish_scene(Scene& scene);

/// Factor s on rho of every material: the asset's volume over that of the fill, one for the scene.
double volume_scale(const VoxelGrid& grid);

/// Estimate of the residual |grad Phi| / |M g_ref| that a number format leaves, by the rounding of
/// displacements in the formulas of a voxel:
///
///     1.5 epsilon 3K / (rho g_ref h)
///
/// of the material with the largest K / rho.
/// @param epsilon  of the format, 2^-23 in float and 2^-52 in double.
double rounding_floor(const Scene& scene, double epsilon);

}  // namespace elastogen
