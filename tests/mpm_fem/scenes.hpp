// SPDX-License-Identifier: Apache-2.0
// Scenes of the integrators' tests.

#pragma once

#include "mpm_fem/fem_scene.hpp"
#include "tests/mpm_fem/bodies.hpp"

#include <cmath>
#include <functional>

namespace elastogen::test {

using fem::FemScene;

inline constexpr double kGravity = 9.81;

/// A mesh in one material; everything is free.
inline FemScene scene_of(ElementMesh mesh, const Material& material) {
  FemScene scene;
  scene.mesh = std::move(mesh);
  scene.materials = {material};
  scene.fixed = Array<uint8_t>(scene.mesh.rest.rows(), 3);
  return scene;
}

/// Box of nx x ny x nz cubes of edge h; of the voxel element the voxels of a grid.
inline FemScene box_of(Element element, int nx, int ny, int nz, double h,
                       const Material& material) {
  if (element != Element::kVoxel) return scene_of(block(element, nx, ny, nz, h), material);
  const Scene grid = voxel_scene(make_box(nx, ny, nz, h), material);
  return scene_of(fem::voxel_mesh(grid, element), material);
}

/// Nodes of the plane X_axis = place.
inline std::vector<int64_t> plane(const ElementMesh& mesh, int axis, double place) {
  std::vector<int64_t> nodes;
  for (int64_t n = 0; n < mesh.rest.rows(); ++n)
    if (std::abs(mesh.rest(n, axis) - place) < 1e-9) nodes.push_back(n);
  return nodes;
}

/// Fixes a component of the nodes of a plane, or all three.
inline void fix(FemScene& scene, int axis, double place, int component) {
  for (const int64_t n : plane(scene.mesh, axis, place)) scene.fixed(n, component) = 1;
}
inline void clamp(FemScene& scene, int axis, double place) {
  for (int i = 0; i < 3; ++i) fix(scene, axis, place, i);
}

/// Mean of a component over the nodes of a plane.
inline double plane_mean(const FemScene& scene, const Array<double>& u, int axis, double place,
                         int component) {
  const std::vector<int64_t> nodes = plane(scene.mesh, axis, place);
  double sum = 0;
  for (const int64_t n : nodes) sum += u(n, component);
  return sum / double(nodes.size());
}

/// Sum of a component over all nodes.
inline double total(const Array<double>& f, int component) {
  double sum = 0;
  for (int64_t n = 0; n < f.rows(); ++n) sum += f(n, component);
  return sum;
}

}  // namespace elastogen::test
