// SPDX-License-Identifier: Apache-2.0
// The rows of the stress catalogue by subject, and the bodies that several of them use.

#pragma once

#include "tests/network/scenes.hpp"
#include "tests/stress/floor.hpp"
#include "tests/stress/runner.hpp"

namespace elastogen::stress {

std::vector<Case> start_cases();     ///< random, flattened, mirrored and twisted starts
std::vector<Case> shape_cases();     ///< single voxels, pieces, sheets, needles, hinges, pins
std::vector<Case> material_cases();  ///< moduli, Poisson's ratio, densities
std::vector<Case> time_cases();      ///< time steps, long runs
std::vector<Case> load_cases();      ///< gravity, impact, scale, place
std::vector<Case> size_cases();      ///< many voxels
std::vector<Case> input_cases();     ///< broken numbers
std::vector<Case> solver_cases();    ///< threads, starved iterations, the published algorithm

/// A finished body of full voxels under gravity along -y, pinned where X_axis <= limit (axis < 0:
/// nowhere).
inline Scene box_scene(int nx, int ny, int nz, double h, const Material& material, int axis = -1) {
  Scene scene = test::scene_on(make_box(nx, ny, nz, h), material);
  if (axis >= 0) test::pin_below(scene, axis, h / 2);
  scene.gravity = {0, -9.81, 0};
  finish_scene(scene);
  return scene;
}

/// A finished scene on voxels at lattice coordinates, nothing pinned.
inline Scene voxel_scene(const std::vector<std::array<int32_t, 3>>& at, double h,
                         const Material& material) {
  Array<int32_t> coords(int64_t(at.size()), 3);
  for (size_t v = 0; v < at.size(); ++v)
    std::copy(at[v].begin(), at[v].end(), coords.row(int64_t(v)));
  Scene scene = test::scene_on(make_grid(coords, h, {}), material);
  scene.gravity = {0, -9.81, 0};
  finish_scene(scene);
  return scene;
}

/// Largest difference of two arrays' entries.
inline double largest_difference(const Array<double>& a, const Array<double>& b) {
  double largest = 0;
  for (int64_t k = 0; k < a.size(); ++k)
    largest = std::max(largest, std::abs(a.data()[k] - b.data()[k]));
  return largest;
}

}  // namespace elastogen::stress
