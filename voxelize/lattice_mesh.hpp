// SPDX-License-Identifier: Apache-2.0
// The surface for the voxeliser: welded, consistently wound, in units of the voxel edge.

#pragma once

#include "core/bricks/index.hpp"
#include "io/weld.hpp"
#include "voxelize/voxelize.hpp"

namespace elastogen {

/// Place of the lattice: point p has the lattice coordinates (p - origin) / h.
struct Lattice {
  double h = 0;      ///< [m]
  Vec3 origin = {};  ///< [m]
  /// Coordinates closer than 1e-9 to a whole number are rounded to it.
  Vec3 coordinates(const double* p) const;
};

/// Chooses the lattice: centred on the surface's box, then moved by half an edge at most along the
/// axes that are to be aligned.
/// @throws Error on bad options; (resources) if the box has 2^20 voxels or more along an axis.
Lattice choose_lattice(const Box& box, const VoxelizeOptions& options);

/// Meaning of a triangle for the solid.
enum class Role : uint8_t {
  kSolid,  ///< it may bound the solid
  kSheet,  ///< it becomes a layer of voxels
  kScrap,  ///< it bounds nothing and is too small for a layer, or lies inside
};

/// Welded triangles, each piece wound consistently.
struct LatticeMesh {
  std::vector<Vec3> vertices;    ///< lattice coordinates
  std::vector<Coord> triangles;  ///< vertices of each
  std::vector<Role> role;        ///< of each
  std::vector<uint8_t> joint;    ///< 1: bounds a solid only together with other pieces; or empty
  int64_t turned = 0;            ///< triangles that were turned
  int64_t sheets = 0;            ///< triangles of sheets
};

/// Turns triangles until the two faces of every edge run along it in opposite directions. A piece
/// keeps the orientation of the larger part of its area. Finds sheets and scraps (sheets.hpp).
LatticeMesh make_lattice_mesh(const WeldedMesh& mesh, const Lattice& lattice);

}  // namespace elastogen
