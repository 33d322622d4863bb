// SPDX-License-Identifier: Apache-2.0
// Bodies whose pins have borders that cut voxels (voxelize/dependent_nodes.hpp).

#pragma once

#include "network/solver.hpp"
#include "tests/network/scenes.hpp"
#include "voxelize/dependent_nodes.hpp"
#include "voxelize/embedding.hpp"
#include "voxelize/thin_cuts.hpp"
#include "voxelize/voxelize.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace elastogen::test {

inline constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// The half space below or above a place along x.
inline Border half_space_border(bool below, double place, int axis = 0) {
  Border border;
  border.is_plane = true;
  border.lower = {-kInfinite, -kInfinite, -kInfinite};
  border.upper = {kInfinite, kInfinite, kInfinite};
  (below ? border.upper : border.lower)[size_t(axis)] = place;
  return border;
}

inline Border ball_border(const Vec3& centre, double radius) {
  Border border;
  border.lower = border.upper = centre;
  border.radius = radius;
  return border;
}

/// The surface of a box.
inline Surface box_surface(const Vec3& lower, const Vec3& upper) {
  constexpr int kCorners[36] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
  Surface surface;
  surface.vertices = Array<double>(8, 3);
  surface.triangles = Array<int32_t>(12, 3);
  surface.material = Array<int32_t>(12);
  for (int c = 0; c < 8; ++c)
    for (int d = 0; d < 3; ++d) surface.vertices(c, d) = (c >> d & 1 ? upper : lower)[size_t(d)];
  std::copy_n(kCorners, 36, surface.triangles.data());
  surface.box.add(lower);
  surface.box.add(upper);
  return surface;
}

/// A body on a grid of edge h that has a layer of nodes at x = align[0] and so on, held at borders;
/// finished, of E 1e8, nu 0.3, rho 1000 under gravity along -y. Borders that the grid fits pin nodes.
inline Scene held_scene(const Surface& surface, const std::vector<Border>& borders, double h,
                        const Vec3& align, double dt = 100) {
  VoxelizeOptions options;
  options.h = h;
  for (size_t d = 0; d < 3; ++d) options.align[d] = align[d];
  options.borders = borders;
  Voxelized made = voxelize(surface, options);
  Scene scene = scene_on(std::move(made.grid), solid(1e8, 0.3));
  for (const Border& border : borders)
    if (fits(border, surface.box, h, scene.grid.origin))
      for (int64_t n = 0; n < scene.grid.node_count(); ++n) {
        const double* X = scene.grid.rest.row(n);
        if (distance(border, {X[0], X[1], X[2]}) <= 1e-6 * h) scene.pinned(n) = kPinnedNode;
      }
  scene.dependent = dependent_nodes(scene.grid, borders, made.cut, scene.pinned);
  join_thin_cuts(borders, made.cut, scene.dependent, scene.grid);
  for (int64_t i = 0; i < scene.dependent.count(); ++i)
    scene.pinned(scene.dependent.node(i)) = kDependentNode;
  scene.gravity = {0, -9.81, 0};
  scene.dt = dt;
  finish_scene(scene);
  return scene;
}

/// The state at rest under the loads, by one long step.
inline State equilibrium(const Scene& scene, StepReport* report = nullptr,
                         double tolerance = 1e-7) {
  SolverOptions options;
  options.mode = SolverMode::kNewton;
  options.tolerance = tolerance;
  Solver solver(scene, options);
  State state = initial_state(scene);
  const StepReport last = solver.step(state);
  EXPECT_TRUE(last.converged) << last.residual;
  if (report) *report = last;
  return state;
}

/// Displacements of points [m], (points, 3).
inline Array<double> displacements(const Scene& scene, const State& state,
                                   const std::vector<Vec3>& points) {
  Array<double> at(int64_t(points.size()), 3), u(at.rows(), 3);
  for (size_t p = 0; p < points.size(); ++p) std::copy_n(points[p].data(), 3, at.row(int64_t(p)));
  deform_asset(scene.grid, embed(scene.grid, at), state.x, u);
  return u;
}

}  // namespace elastogen::test
