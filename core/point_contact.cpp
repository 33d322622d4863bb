// SPDX-License-Identifier: Apache-2.0
#include "core/point_contact.hpp"

#include "core/constants.hpp"
#include "core/scene.hpp"
#include "core/vec3.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {

double contact_layer(const Scene& scene) {
  return scene.grid.h / 4;
}

double slip_range(const Scene& scene) {
  Box box;
  const Array<double>& X = scene.surface.position;
  for (int64_t p = 0; p < X.rows(); ++p) box.add({X(p, 0), X(p, 1), X(p, 2)});
  const double size = std::max({box.extent(0), box.extent(1), box.extent(2), scene.grid.h});
  return 1e-3 * std::sqrt(kReferenceGravity * size) * scene.dt;
}

ContactLengths contact_lengths(const Scene& scene) {
  return {.layer = contact_layer(scene), .slip_range = slip_range(scene)};
}

}  // namespace elastogen
