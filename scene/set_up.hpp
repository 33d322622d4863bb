// SPDX-License-Identifier: Apache-2.0
// Turns an asset and the description of a run into a finished scene.

#pragma once

#include "io/asset.hpp"
#include "io/report_file.hpp"
#include "mpm_fem/mpm/particles.hpp"
#include "scene/asset_part.hpp"
#include "scene/description.hpp"
#include "scene/tet_asset.hpp"
#include "voxelize/body.hpp"
#include "voxelize/border.hpp"

#include <optional>

namespace elastogen {

/// Particles that replace the grid in the steps.
struct ParticleSetup {
  mpm::Particles particles;  ///< positions relative to the grid's origin [m]
  VoxelGrid nodes;           ///< only h, origin and rest positions of the particles [m]
  Array<int32_t> voxel;      ///< voxel that each particle fills, (particles, 1), or empty
  int dimension = 3;         ///< 2: in the plane z = 0
  double spacing = 0;        ///< of particles in a full voxel [m]
  std::vector<Border> held;  ///< behind which grid nodes are pinned, positions as of particles
  Asset shown;               ///< the particles as a cloud with the asset's colours
  std::vector<std::string> notes;  ///< notes on these colours
};

/// A border that holds the body where it cuts voxels, and a point behind one; each with its holder.
struct HeldBorder {
  Border border;
  int32_t holder;
};
struct HeldPoint {
  int64_t point;
  int32_t holder;
};
/// A point of the surface behind the border of a move.
struct MovedPoint {
  Vec3 rest;  ///< [m]
  int32_t holder;
};

/// Tetrahedra that pins and moves cut: what is free, and all nodes with what holds them
/// (nodes_with_holders).
struct CutMesh {
  fem::ElementMesh mesh;
  Scene nodes;
};

struct Setup {
  Body body;
  Scene scene;
  std::vector<Yield> yields;  ///< yield of each material of the scene; empty: all are elastic
  /// Tetrahedra that are stepped as in the file [m]. The scene's grid then only has their nodes as
  /// rest and mean_edge as h.
  std::optional<fem::ElementMesh> tets;
  std::optional<ParticleSetup> particles;  ///< for bodies that fall apart into grains
  Array<int32_t> node_of;                  ///< with tets: node of each carried point, (points, 1)
  std::vector<HeldBorder> borders;         ///< that cut voxels or tetrahedra
  std::vector<AssetPart> parts;            ///< that options of the run select
  std::vector<HeldPoint> held_points;      ///< of parts that are held or moved by holders
  std::vector<MovedPoint> moved_points;    ///< that no step asks about colliders (moved_points.hpp)
  std::optional<CutMesh> cut_mesh;         ///< in place of tetrahedra that borders cut
  int substeps = 1;
  double longest_edge = 0;                       ///< of the asset [m]
  double sheet_volume = 0, sheet_thickness = 0;  ///< of sheets and shells [m^3], [m]
  UpAxis up;

  // for the report
  AssetSummary asset;
  std::vector<std::string> warnings;
  double voxelize_seconds = 0, other_seconds = 0;
};

/// Poses, voxelises and pins the asset.
/// @throws Error (usage) for contradictions and bodies that begin inside a collider; as voxelize.
Setup set_up(const Asset& asset, const RunDescription& run);

/// Sets up a mesh of tetrahedra, which is neither voxelised nor cut.
/// @throws Error (usage) if the element asked for does not fit the file's.
Setup set_up(const TetAsset& tets, const RunDescription& run);

/// Fills a report from a setup: asset, voxels, materials, warnings and times.
void add_summary(const Setup& setup, RunReport& report);

}  // namespace elastogen
