// SPDX-License-Identifier: Apache-2.0
// Reads an asset, voxelises it and lets it fall for ten steps, on the network and on finite
// elements: x = x_0 + g t (t + dt)/2.

#include "core/error.hpp"
#include "io/read_asset.hpp"
#include "mpm_fem/integrators/implicit_fem.hpp"
#include "network/solver.hpp"
#include "voxelize/voxelize.hpp"

#include <cmath>
#include <cstdio>

namespace {

/// Displacement of the first node after ten steps of finite elements [m].
double fallen_by_finite_elements(const elastogen::Scene& scene) {
  using namespace elastogen::fem;
  FemScene body;
  body.mesh = voxel_mesh(scene, Element::kHex);
  body.materials = scene.materials;
  body.mass = scene.mass;
  body.gravity = scene.gravity;
  body.dt = scene.dt;
  FemState state = rest_state(body);
  ImplicitFem fem(body);
  for (int k = 0; k < 10; ++k)
    if (!fem.step(state).converged) return 0;
  return state.u(0, 1);
}

}  // namespace

int main(int argc, char** argv) {
  using namespace elastogen;
  if (argc != 2) return 2;
  try {
    // asset, voxels, scene
    const Surface surface = pose_surface(read_asset(argv[1]));
    Scene scene;
    scene.grid = voxelize(surface, {.voxels = 8}).grid;
    scene.material = Array<int32_t>(scene.grid.voxel_count());
    scene.pinned = Array<uint8_t>(scene.grid.node_count());
    scene.gravity = {0, -9.81, 0};
    finish_scene(scene);
    // ten steps of free fall
    State state = initial_state(scene);
    Solver solver(scene, {});
    for (int k = 0; k < 10; ++k)
      if (!solver.step(state).converged) return 4;
    // both methods against x_0 + g t (t + dt)/2
    const double expected = -9.81 * state.time * (state.time + scene.dt) / 2;
    const double fallen = state.x(0, 1) - scene.grid.rest(0, 1);
    std::printf("%lld voxels fell by %.6f m\n", static_cast<long long>(scene.grid.voxel_count()),
                -fallen);
    if (std::abs(fallen_by_finite_elements(scene) - expected) > 1e-9) return 1;
    return std::abs(fallen - expected) < 1e-6 ? 0 : 1;
  } catch (const Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 3;
  }
}
