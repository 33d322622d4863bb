// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/mpm/mpm_scene.hpp"

#include "core/error.hpp"

#include <cmath>

namespace elastogen::mpm {

double wave_speed(const Material& material) {
  return std::sqrt((material.lambda() + 2 * material.mu()) / material.density);
}

void check_scene(const MpmScene& scene) {
  ELASTOGEN_CHECK(scene.dimension == 2 || scene.dimension == 3,
                  "the dimension must be 2 or 3, got ", scene.dimension);
  ELASTOGEN_CHECK(scene.h > 0 && std::isfinite(scene.h), "h must be positive, got ", scene.h);
  ELASTOGEN_CHECK(scene.dt > 0 && std::isfinite(scene.dt), "dt must be positive, got ", scene.dt);
  ELASTOGEN_CHECK(!scene.solids.empty(), "the scene has no solids");
  for (const Obstacle& obstacle : scene.obstacles)
    if (!obstacle.held) check_collider(obstacle.collider);
  ELASTOGEN_CHECK(scene.transfer.blend_time > 0, "blend_time must be positive, got ",
                  scene.transfer.blend_time);
  ELASTOGEN_CHECK(scene.transfer.flip >= 0 && scene.transfer.flip <= 1,
                  "flip must lie in [0, 1], got ", scene.transfer.flip);
}

}  // namespace elastogen::mpm
