// SPDX-License-Identifier: Apache-2.0
// Bodies that the grid cuts, in equilibrium under large loads: with the network's element on the
// voxels of the command's voxeliser, and with quadratic tetrahedra that fit the boundary.

#pragma once

#include "mpm_fem/integrators/static_fem.hpp"
#include "tests/curved/mapped_body.hpp"
#include "tests/curved/tet_field.hpp"

#include <map>
#include <optional>
#include <string>

namespace elastogen::test {

struct CurvedScene {
  std::string load;  ///< what it is, for tables
  MappedBody body;
  double length = 0;  ///< [m] that the counts of voxels stand for
  /// Held planes must be planes of nodes, where both models hold the same material points.
  std::optional<double> planes[3] = {};
  /// Body and loads are symmetric about the three planes through 0: both models are those of an
  /// octant, of a grid with nodes in the planes.
  bool octant = false;
  Material material;
  std::function<Vec3(const Vec3& X)> acceleration;  ///< [m/s^2]
  /// Displacement of a component that is held [m] at a load factor in 0 ... 1; nothing where it is
  /// free.
  std::function<std::optional<double>(const Vec3& X, int axis, double factor)> held;
  /// n of mapped_tets for three references, each twice as fine as the one before.
  int tets = 2;
};

/// Scenes by name.
const std::map<std::string, CurvedScene>& curved_scenes();

/// The reference in equilibrium.
struct TetSolution {
  fem::ElementMesh mesh;
  Array<double> u;  ///< [m], (nodes, 3)
  double min_j = 0;
};
/// @param coarse  a solution on a coarser mesh to start from; 0: load by load from rest.
/// @throws Error if there is no equilibrium.
TetSolution solve_tets(const CurvedScene& scene, int n, const TetSolution* coarse = nullptr);

/// Voxels in equilibrium. Fills, means, slivers and floor are those of the command; in an octant
/// the nodes of the other ones stay 0.
struct VoxelSolution {
  Scene scene;          ///< the grid of the whole body
  Array<double> u;      ///< [m], (nodes of the grid, 3)
  Array<double> mass;   ///< of the nodes that were solved for, else 0 [kg], (nodes of the grid, 1)
  int64_t slivers = 0;  ///< voxels left out
  double min_j = 0;

  /// Displacement of points that the grid carries [m], (points, 3).
  Array<double> at(const Array<double>& points) const;
};
/// @param triangles  cells of the coarsest mesh are cut into so many along each axis for the
///                   surface.
VoxelSolution solve_voxels(const CurvedScene& scene, int voxels, int triangles = 32);

/// Material points with weights and the true displacement there.
struct Points {
  Array<double> place;  ///< [m], (points, 3)
  Array<double> weight;
  Array<double> u;  ///< [m], (points, 3)
};

/// The nodes of a grid that lie in the body, with their masses.
Points points_inside(const VoxelSolution& grid, const TetSolution& truth);
/// The nodes of a coarser mesh that lie on the body's boundary, each weighted alike; of an octant
/// those on its planes do not count.
Points points_on_surface(const CurvedScene& scene, const TetSolution& coarse,
                         const TetSolution& truth);

/// sqrt(sum w |u - truth|^2 / sum w |truth|^2).
double relative_error(const Array<double>& u, const Points& truth);

}  // namespace elastogen::test
