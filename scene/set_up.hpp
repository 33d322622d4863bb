// SPDX-License-Identifier: Apache-2.0
// From an asset and the description of a run to a finished scene.

#pragma once

#include "io/asset.hpp"
#include "io/report_file.hpp"
#include "mpm_fem/mpm/particles.hpp"
#include "scene/description.hpp"
#include "scene/tet_asset.hpp"
#include "voxelize/body.hpp"

#include <optional>

namespace elastogen {

/// Particles that take the steps in place of the grid.
struct ParticleSetup {
  mpm::Particles particles;        ///< places in the grid's coordinates less its origin [m]
  VoxelGrid nodes;                 ///< of h, origin and their places at rest [m] only
  Array<int32_t> voxel;            ///< of the scene's grid that each fills, (particles, 1), or none
  int dimension = 3;               ///< 2: in the plane z = 0
  double spacing = 0;              ///< of those that fill a voxel [m]
  Asset shown;                     ///< a cloud of them, with the asset's colours
  std::vector<std::string> notes;  ///< on these colours
};

struct Setup {
  Body body;
  Scene scene;
  std::vector<Yield> yields;  ///< of each of the scene's materials; empty: all are elastic
  /// Tetrahedra that are stepped as the file has them [m]; the scene's grid then has only their
  /// nodes as rest, and mean_edge as h.
  std::optional<fem::ElementMesh> tets;
  std::optional<ParticleSetup> particles;  ///< of bodies that fall apart into grains
  Array<int32_t> node_of;                  ///< with tets: node of each carried point, (points, 1)
  int substeps = 1;
  double longest_edge = 0;                       ///< of the asset [m]
  double sheet_volume = 0, sheet_thickness = 0;  ///< of sheets and shells [m^3], [m]
  UpAxis up;

  // what a report says of it
  AssetSummary asset;
  std::vector<std::string> warnings;
  double voxelize_seconds = 0, other_seconds = 0;
};

/// Poses, voxelises and pins the asset.
/// @throws Error (usage) for what contradicts itself or begins inside a collider; as voxelize.
Setup set_up(const Asset& asset, const RunDescription& run);

/// The same of a mesh of tetrahedra, which is neither voxelised nor cut.
/// @throws Error (usage) where the element asked for is of another kind than the file's.
Setup set_up(const TetAsset& tets, const RunDescription& run);

/// What a report says of a setup: asset, voxels, materials, warnings and times.
void add_summary(const Setup& setup, RunReport& report);

}  // namespace elastogen
