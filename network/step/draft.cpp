// SPDX-License-Identifier: Apache-2.0
#include "network/step/draft.hpp"

#include "core/error.hpp"
#include "core/vec3.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>

namespace elastogen {
namespace {

/// Young's modulus of the stiffest voxel of a node [Pa].
double young_at(const Scene& scene, int64_t node) {
  double young = 0;
  for (int c = 0; c < 8; ++c) {
    const int32_t voxel = scene.grid.voxels(node, c);
    if (voxel >= 0) young = std::max(young, scene.materials[size_t(scene.material(voxel))].young);
  }
  return young;
}

/// rho g L / E of the material where that is largest, L the longest edge of the body's box.
double weight_over_stiffness(const Scene& scene) {
  double longest = 0, softness = 0;
  for (int d = 0; d < 3; ++d) {
    double low = INFINITY, high = -INFINITY;
    for (int64_t n = 0; n < scene.grid.rest.rows(); ++n) {
      low = std::min(low, scene.grid.rest(n, d));
      high = std::max(high, scene.grid.rest(n, d));
    }
    longest = std::max(longest, high - low);
  }
  for (const Material& m : scene.materials) softness = std::max(softness, m.density / m.young);
  return softness * safe_norm(scene.gravity) * longest;
}

}  // namespace

std::string why_draft(const Scene& scene, const StepReport& step, Span<const double> gradient) {
  // the node with the largest force
  int64_t worst = 0;
  double largest = -1;
  for (int64_t n = 0; n < scene.grid.rest.rows(); ++n) {
    if (scene.pinned(n) != kFreeNode) continue;
    const double force = safe_norm({gradient(n, 0), gradient(n, 1), gradient(n, 2)});
    if (force > largest) largest = force, worst = n;
  }
  const double h = scene.grid.h, young = young_at(scene, worst);
  Vec3 at = scene.place;
  for (int d = 0; d < 3; ++d) at[size_t(d)] += scene.grid.rest(worst, d);

  std::string text =
      concat("step ", step.step, " is not solved: residual ", std::setprecision(3), step.residual,
             " (", step.tolerance, " allowed) after ", step.outer, " outer and ", step.inner,
             " inner iterations; the largest force out of balance, ", largest, " N or ",
             largest / (young * h * h), " E h^2, is at (", at[0], ", ", at[1], ", ", at[2],
             ") m of the body at rest");
  if (step.min_j < 0.1)
    text += concat("; the smallest det F is ", std::setprecision(2), step.min_j);
  if (const double share = weight_over_stiffness(scene); share > 0.01)
    text += concat("; the body shortens by about ", std::setprecision(2), 100 * share,
                   " % under its own weight");
  return text;
}

}  // namespace elastogen
