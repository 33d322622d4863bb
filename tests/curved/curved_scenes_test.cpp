// SPDX-License-Identifier: Apache-2.0
// The smallest grids of bodies that a grid cuts; all: tests/scenes/curved.py.

#include "tests/curved/curved_scene.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace elastogen::test {
namespace {

/// Errors at the nodes inside on 8 and 16 voxels along the body, against the middle one of the
/// three references.
std::array<double, 2> errors_of(const std::string& name) {
  const CurvedScene& scene = curved_scenes().at(name);
  const TetSolution coarse = solve_tets(scene, scene.tets);
  const TetSolution truth = solve_tets(scene, 2 * scene.tets, &coarse);
  const VoxelSolution grids[] = {solve_voxels(scene, 8), solve_voxels(scene, 16)};
  const Points inside = points_inside(grids[0], truth);
  EXPECT_GT(inside.place.rows(), 10);
  std::array<double, 2> errors;
  for (size_t k = 0; k < 2; ++k) errors[k] = relative_error(grids[k].at(inside.place), inside);
  std::printf("%s: %.2e, %.2e, order %.2f\n", name.c_str(), errors[0], errors[1],
              std::log2(errors[0] / errors[1]));
  return errors;
}

TEST(CurvedScenes, AFreeBallIsOfSecondOrder) {
  for (const char* name : {"pulled ball", "pressed ball"}) {
    const auto [coarse, fine] = errors_of(name);
    EXPECT_LT(fine, 0.02) << name;
    EXPECT_GT(std::log2(coarse / fine), 1.7) << name;
  }
}

TEST(CurvedScenes, BodiesThatAreHeldConvergeToo) {
  const auto [bar_coarse, bar] = errors_of("turned bar");
  EXPECT_LT(bar, 0.04);
  EXPECT_GT(std::log2(bar_coarse / bar), 1.4);
  const auto [hook_coarse, hook] = errors_of("hook");
  EXPECT_LT(hook, 0.05);
  EXPECT_GT(std::log2(hook_coarse / hook), 1.4);
}

TEST(CurvedScenes, AnOctantMovesAsTheWholeDoes) {
  const CurvedScene& octant = curved_scenes().at("pulled ball");
  CurvedScene whole = octant;
  whole.octant = false;
  whole.held = [](const Vec3& X, int axis, double) -> std::optional<double> {
    return std::abs(X[size_t(axis)]) < 1e-9 ? std::optional(0.0) : std::nullopt;
  };
  const VoxelSolution part = solve_voxels(octant, 8), all = solve_voxels(whole, 8);
  ASSERT_EQ(part.u.rows(), all.u.rows());
  double difference = 0, largest = 0;
  for (int64_t n = 0; n < part.u.rows(); ++n) {
    if (part.mass(n) == 0) continue;
    for (int d = 0; d < 3; ++d) {
      difference = std::max(difference, std::abs(part.u(n, d) - all.u(n, d)));
      largest = std::max(largest, std::abs(all.u(n, d)));
    }
  }
  std::printf("octant and whole differ by %.1e of %.3f m\n", difference, largest);
  EXPECT_LT(difference, 1e-6 * largest);
}

}  // namespace
}  // namespace elastogen::test
