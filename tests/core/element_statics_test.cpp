// SPDX-License-Identifier: Apache-2.0
// Patch tests of boxes and ragged shapes of voxels, assembled from the element.

#include "tests/support/element_assembly.hpp"
#include "tests/support/laws.hpp"
#include "tests/support/matrices.hpp"
#include "voxelize/bricks.hpp"

#include <gtest/gtest.h>

namespace elastogen {
namespace {

using test::box_scene;
using test::Random;

Material element_solid(double young, double poisson, double density = 1000) {
  return {"test", Law::kNeoHookean, young, poisson, density};
}

/// A box with a hole and rough sides; every voxel full.
VoxelGrid ragged_grid(double h) {
  Random random(1);
  std::vector<int32_t> kept;
  for (int z = 0; z < 6; ++z)
    for (int y = 0; y < 6; ++y)
      for (int x = 0; x < 6; ++x) {
        const bool core = x > 0 && x < 5 && y > 0 && y < 5 && z > 0 && z < 5;
        if (core ? x * y * z != 1 : random() % 2 == 0) kept.insert(kept.end(), {x, y, z});
      }
  return make_grid({kept.data(), int64_t(kept.size() / 3), 3}, h, {-1, 2, 0.5});
}

bool interior(const VoxelGrid& grid, int64_t node) {
  for (int c = 0; c < 8; ++c)
    if (grid.voxels(node, c) < 0) return false;
  return true;
}

Eigen::VectorXd linear_field(const VoxelGrid& grid, const Mat3<double>& H) {
  Eigen::VectorXd u(3 * grid.node_count());
  for (int64_t n = 0; n < grid.node_count(); ++n)
    for (int i = 0; i < 3; ++i) {
      u(3 * n + i) = 0;
      for (int j = 0; j < 3; ++j) u(3 * n + i) += H(i, j) * grid.rest(n, j);
    }
  return u;
}

std::map<int, double> hold_boundary(const VoxelGrid& grid, const Eigen::VectorXd& u) {
  std::map<int, double> held;
  for (int64_t n = 0; n < grid.node_count(); ++n)
    if (!interior(grid, n))
      for (int i = 0; i < 3; ++i) held[int(3 * n + i)] = u(3 * n + i);
  return held;
}

/// Mean stress of a voxel from its corner forces: sum of f (x) X over the volume.
Mat3<double> virial_stress(const Scene& scene, int64_t voxel, const Eigen::VectorXd& u) {
  double corner[3][8], f[3][8];
  test::gather(scene.grid, voxel, u, corner);
  voxel_rest_hessian<true>(test::voxel_data(scene, voxel), corner, f);
  Mat3<double> stress{};
  for (int c = 0; c < 8; ++c)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        stress(i, j) += f[i][c] * scene.grid.rest(scene.grid.corners(voxel, c), j);
  return test::scaled(stress, 1 / (scene.grid.h * scene.grid.h * scene.grid.h));
}

TEST(ElementStatics, LinearPatchTestIsExactOnBoxAndRaggedShape) {
  constexpr double kStrain = 5e-4;
  const Mat3<double> H = test::scaled({{2, 1, 1, 1, 2, 1, 1, 1, 2}}, kStrain);
  for (const Hourglass hourglass : {Hourglass::kFull, Hourglass::kVariance})
    for (const VoxelGrid& grid : {make_box(4, 3, 5, 0.25), ragged_grid(0.25)}) {
      const Scene scene = test::scene_of(grid, element_solid(1e6, 0.25), hourglass);
      const Eigen::VectorXd exact = linear_field(grid, H);
      const std::map<int, double> held = hold_boundary(grid, exact);
      ASSERT_LT(int64_t(held.size()), exact.size());
      const Eigen::VectorXd zero = Eigen::VectorXd::Zero(exact.size());
      const Eigen::VectorXd u = test::solve(test::rest_stiffness(scene), zero, held);
      EXPECT_LE((u - exact).norm(), 1e-10 * exact.norm());
      for (int64_t v = 0; v < grid.voxel_count(); ++v) {
        const Mat3<double> stress = virial_stress(scene, v, u);
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j) ASSERT_NEAR(stress(i, j), i == j ? 2000 : 400, 1e-6);
      }
    }
}

/// Newton's method from rest with the boundary held.
Eigen::VectorXd newton(const Scene& scene, const Eigen::VectorXd& boundary) {
  const VoxelGrid& grid = scene.grid;
  std::map<int, double> held = hold_boundary(grid, boundary), fixed = held;
  for (auto& [dof, value] : fixed) value = 0;
  Eigen::VectorXd u = Eigen::VectorXd::Zero(boundary.size());
  // the boundary moves in two steps
  for (int k = 0; k < 14; ++k) {
    for (const auto& [dof, value] : held) u(dof) = k < 3 ? value / 2 : value;
    const auto element = [&](int64_t v) {
      const VoxelData<double> data = test::voxel_data(scene, v);
      double corner[3][8];
      test::gather(grid, v, u, corner);
      const Tangent<double> tangent = voxel_tangent<true>(data, corner);
      return test::corner_matrix(
          [&](const double p[3][8], double f[3][8]) { voxel_hessian<true>(data, tangent, p, f); });
    };
    u -= test::solve(test::assemble(grid, element), test::internal_gradient(scene, u), fixed);
  }
  return u;
}

TEST(ElementStatics, FinitePatchTestEndsInTheUniformGradientForEveryLaw) {
  const Mat3<double> H = {{0.2, 0.3, -0.1, 0.05, -0.15, 0.1, 0.1, -0.2, 0.1}};
  for (const Law law : test::kLaws) {
    Material material = element_solid(1, 0.3);
    material.law = law;
    const Scene scene = box_scene(3, 3, 3, 0.5, material);
    const Eigen::VectorXd exact = linear_field(scene.grid, H);
    EXPECT_LE((newton(scene, exact) - exact).norm(), 1e-8 * exact.norm()) << law_name(law);
  }
}

}  // namespace
}  // namespace elastogen
