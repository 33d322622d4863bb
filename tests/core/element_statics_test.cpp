// SPDX-License-Identifier: Apache-2.0
// Linear statics of boxes of voxels, assembled from the element: patch tests, bending against
// Timoshenko, twist against Saint-Venant. Constraints on single components exist only here.

#include "tests/support/element_assembly.hpp"
#include "tests/support/laws.hpp"
#include "tests/support/matrices.hpp"
#include "voxelize/bricks.hpp"

#include <gtest/gtest.h>

namespace elastogen {
namespace {

using test::box_scene;
using test::Random;

Material solid(double young, double poisson, double density = 1000) {
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
      const Scene scene = test::scene_of(grid, solid(1e6, 0.25), hourglass);
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
    Material material = solid(1, 0.3);
    material.law = law;
    const Scene scene = box_scene(3, 3, 3, 0.5, material);
    const Eigen::VectorXd exact = linear_field(scene.grid, H);
    EXPECT_LE((newton(scene, exact) - exact).norm(), 1e-8 * exact.norm()) << law_name(law);
  }
}

/// Mean displacement component over the nodes of the plane x = place, weighted by their area.
double plane_mean(const VoxelGrid& grid, const Eigen::VectorXd& u, int place, int component) {
  double sum = 0, weight = 0;
  for (int64_t n = 0; n < grid.node_count(); ++n) {
    if (grid.node_coord(n, 0) != place) continue;
    int share = 0;
    for (int c = 0; c < 8; ++c) share += grid.voxels(n, c) >= 0;
    sum += share * u(3 * n + component), weight += share;
  }
  return sum / weight;
}

int64_t node_at(const VoxelGrid& grid, int x, int y, int z) {
  for (int64_t n = 0; n < grid.node_count(); ++n)
    if (grid.node_coord(n, 0) == x && grid.node_coord(n, 1) == y && grid.node_coord(n, 2) == z)
      return n;
  return -1;
}

/// Share of node k of n + 1 over the thickness in the traction 3/2 (1 - (2 z/t)^2) of mean 1.
double parabola_share(int k, int n) {
  constexpr double kPoint[3] = {0.112701665379258, 0.5, 0.887298334620742};
  constexpr double kWeight[3] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
  double share = 0;
  for (const int layer : {k - 1, k}) {
    if (layer < 0 || layer >= n) continue;
    for (int q = 0; q < 3; ++q) {
      const double z = 2 * (layer + kPoint[q]) / n - 1;
      const double hat = layer == k ? 1 - kPoint[q] : kPoint[q];
      share += kWeight[q] * hat * 1.5 * (1 - z * z) / n;
    }
  }
  return share;
}

enum class Root { kClamped, kContracting };

/// Holds the root face of a beam n voxels thick. A contracting root keeps its plane, carries the
/// weight as a parabolic shear traction, and is held against rigid motion without a reaction.
std::map<int, double> hold_root(const VoxelGrid& grid, int n, Root root, double weight,
                                Eigen::VectorXd& f) {
  std::map<int, double> held;
  for (int64_t k = 0; k < grid.node_count(); ++k) {
    if (grid.node_coord(k, 0) > 0) continue;
    held[int(3 * k)] = 0;
    if (root == Root::kClamped) {
      held[int(3 * k + 1)] = held[int(3 * k + 2)] = 0;
      continue;
    }
    const int y = grid.node_coord(k, 1);
    const double across = (y == 0 || y == n ? 0.5 : 1.0) / n;
    f(3 * k + 2) += weight * across * parabola_share(grid.node_coord(k, 2), n);
  }
  const int corner = int(3 * node_at(grid, 0, 0, 0)), side = int(3 * node_at(grid, 0, n, 0));
  held[corner + 1] = held[corner + 2] = held[side + 2] = 0;
  return held;
}

/// The beam 10n x n x n with L = 1, E = 1e8, rho = 1000, bent by its own weight.
struct Cantilever {
  double error = 0;     ///< deflection against Timoshenko's [per cent]
  double variance = 0;  ///< share of the strain-variance term in the energy [per cent]
};

Cantilever cantilever(int n, double poisson, Root root, Hourglass hourglass) {
  constexpr double kYoung = 1e8, kDensity = 1000, kGravity = 9.81, kThick = 0.1;
  constexpr double kArea = kThick * kThick, kInertia = kArea * kArea / 12;
  constexpr double kLoad = kDensity * kGravity * kArea;
  Scene scene = box_scene(10 * n, n, n, kThick / n, solid(kYoung, poisson, kDensity), hourglass);
  Eigen::VectorXd f = Eigen::VectorXd::Zero(3 * scene.grid.node_count());
  for (int64_t k = 0; k < scene.grid.node_count(); ++k) f(3 * k + 2) = -scene.mass(k) * kGravity;
  const std::map<int, double> held = hold_root(scene.grid, n, root, kLoad, f);
  const Eigen::SparseMatrix<double> K = test::rest_stiffness(scene);
  const Eigen::VectorXd u = test::solve(K, f, held);

  const double kappa = 10 * (1 + poisson) / (12 + 11 * poisson);
  const double shear_modulus = kYoung / (2 * (1 + poisson));
  const double timoshenko =
      kLoad / (8 * kYoung * kInertia) + kLoad / (2 * kappa * shear_modulus * kArea);
  const double deflection = plane_mean(scene.grid, u, 0, 2) - plane_mean(scene.grid, u, 10 * n, 2);
  scene.hourglass = Hourglass::kOff;
  const double energy = u.dot(K * u), without = u.dot(test::rest_stiffness(scene) * u);
  return {100 * (deflection / timoshenko - 1), 100 * (1 - without / energy)};
}

constexpr double kPoisson[5] = {0, 0.3, 0.45, 0.49, 0.499};

TEST(ElementStatics, BeamTwoVoxelsThickBendsAsTimoshenkoSaysAtEveryPoissonRatio) {
  const double per_cent[5] = {-0.13, 1.19, 0.24, -0.17, -0.27};
  for (const Hourglass hourglass : {Hourglass::kFull, Hourglass::kVariance})
    for (int k = 0; k < 5; ++k) {
      const double error = cantilever(2, kPoisson[k], Root::kContracting, hourglass).error;
      EXPECT_LE(std::abs(error), 2) << kPoisson[k];
      EXPECT_NEAR(error, per_cent[k], 0.2) << kPoisson[k];
    }
}

TEST(ElementStatics, ClampedBeamTwoVoxelsThickBendsAsTheTableSays) {
  const double full[5] = {-0.13, 0.08, -2.77, -4.00, -4.32};
  const double variance[5] = {-0.13, 0.02, -2.94, -4.21, -4.53};
  for (int k = 0; k < 5; ++k) {
    const auto error = [&](Hourglass hourglass) {
      return cantilever(2, kPoisson[k], Root::kClamped, hourglass).error;
    };
    EXPECT_NEAR(error(Hourglass::kFull), full[k], 0.1) << kPoisson[k];
    EXPECT_NEAR(error(Hourglass::kVariance), variance[k], 0.1) << kPoisson[k];
  }
}

TEST(ElementStatics, ShareOfTheVarianceTermInBendingFallsWithTheSquareOfTheResolution) {
  const auto share = [](int n, double poisson) {
    return cantilever(n, poisson, Root::kClamped, Hourglass::kVariance).variance;
  };
  EXPECT_NEAR(share(1, 0), 98.9, 0.5);
  EXPECT_NEAR(share(2, 0), 24.7, 0.5);
  EXPECT_NEAR(share(4, 0), 6.2, 0.5);
  EXPECT_NEAR(share(2, 0.499), 25.4, 0.5);
  EXPECT_NEAR(share(4, 0.499), 7.0, 0.5);
}

TEST(ElementStatics, StripOneVoxelThickBendsAsTimoshenkoSaysAtEveryPoissonRatio) {
  const double per_cent[5] = {-0.13, -0.15, -0.16, -0.16, -0.16};
  for (int k = 0; k < 5; ++k) {
    const Cantilever strip = cantilever(1, kPoisson[k], Root::kContracting, Hourglass::kVariance);
    EXPECT_NEAR(strip.error, per_cent[k], 0.1) << kPoisson[k];
  }
}

TEST(ElementStatics, SheetOneVoxelThickBendsAsAPlate) {
  for (const double poisson : kPoisson) {
    constexpr double kYoung = 1e8, kThick = 0.05, kGravity = 9.81;
    const Scene scene = box_scene(20, 2, 1, kThick, solid(kYoung, poisson));
    const VoxelGrid& grid = scene.grid;
    Eigen::VectorXd f = Eigen::VectorXd::Zero(3 * grid.node_count());
    std::map<int, double> held;
    for (int64_t n = 0; n < grid.node_count(); ++n) {
      f(3 * n + 2) = -scene.mass(n) * kGravity;
      held[int(3 * n + 1)] = 0;
      if (grid.node_coord(n, 0) == 0) held[int(3 * n)] = held[int(3 * n + 2)] = 0;
    }
    const Eigen::VectorXd u = test::solve(test::rest_stiffness(scene), f, held);
    const double rigidity = kYoung * std::pow(kThick, 3) / (12 * (1 - poisson * poisson));
    const double reference = 1000 * kGravity * kThick / (8 * rigidity);
    EXPECT_NEAR(-plane_mean(grid, u, 20, 2) / reference, 1, 0.005) << poisson;
  }
}

TEST(ElementStatics, PartlyFilledStripHasTheBendingStiffnessOfItsThickness) {
  for (const double fill : {0.5, 0.25}) {
    VoxelGrid grid = make_box(20, 1, 1, 0.1);
    grid.fill.fill(fill);
    const Scene scene = test::scene_of(grid, solid(1e6, 0));
    Eigen::VectorXd f = Eigen::VectorXd::Zero(3 * grid.node_count());
    std::map<int, double> held;
    for (int64_t n = 0; n < grid.node_count(); ++n) {
      if (grid.node_coord(n, 0) == 20) f(3 * n + 2) = 0.25;
      for (int i = 0; i < 3; ++i)
        if (grid.node_coord(n, 0) == 0) held[int(3 * n + i)] = 0;
    }
    const Eigen::VectorXd u = test::solve(test::rest_stiffness(scene), f, held);
    const double inertia = std::pow(0.1, 4) * std::pow(fill, 3) / 12;
    EXPECT_NEAR(plane_mean(grid, u, 20, 2) * 3 * 1e6 * inertia / 8, 1, 0.01) << fill;
  }
}

/// Torsional stiffness of the bar 4n x n x n, warping free, over Saint-Venant's.
double twist_ratio(int n, double poisson, Hourglass hourglass) {
  const Scene scene = box_scene(4 * n, n, n, 1.0 / n, solid(1, poisson), hourglass);
  const VoxelGrid& grid = scene.grid;
  std::map<int, double> held;
  for (int64_t k = 0; k < grid.node_count(); ++k) {
    const int x = grid.node_coord(k, 0);
    if (x != 0 && x != 4 * n) continue;
    const double angle = x == 0 ? -0.5 : 0.5;
    held[int(3 * k + 1)] = -angle * (grid.rest(k, 2) - 0.5);
    held[int(3 * k + 2)] = angle * (grid.rest(k, 1) - 0.5);
  }
  held[int(3 * node_at(grid, 0, 0, 0))] = 0;
  const Eigen::SparseMatrix<double> K = test::rest_stiffness(scene);
  const Eigen::VectorXd u = test::solve(K, Eigen::VectorXd::Zero(K.rows()), held);
  // twice the energy is torque times angle; the angle is 1, the length 4, the side 1
  const double shear_modulus = 1 / (2 * (1 + poisson));
  return u.dot(K * u) * 4 / (0.140577 * shear_modulus);
}

TEST(ElementStatics, TwistWithTheTorsionCorrectionIsThatOfTheTableAtEveryPoissonRatio) {
  for (const double poisson : {0.0, 0.3, 0.499}) {
    EXPECT_NEAR(twist_ratio(2, poisson, Hourglass::kFull), 1.186, 1e-3);
    EXPECT_NEAR(twist_ratio(3, poisson, Hourglass::kFull), 1.090, 1e-3);
    EXPECT_NEAR(twist_ratio(4, poisson, Hourglass::kFull), 1.052, 1e-3);
  }
}

TEST(ElementStatics, TwistWithoutTheCorrectionIsTooStiffByWhatTheTableSays) {
  EXPECT_NEAR(twist_ratio(2, 0, Hourglass::kVariance), 1.48, 0.01);
  EXPECT_NEAR(twist_ratio(2, 0.3, Hourglass::kVariance), 1.57, 0.01);
  EXPECT_NEAR(twist_ratio(2, 0.499, Hourglass::kVariance), 1.63, 0.01);
}

}  // namespace
}  // namespace elastogen
