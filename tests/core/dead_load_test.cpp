// SPDX-License-Identifier: Apache-2.0
// One voxel under dead loads on its faces: its equilibrium is the material's response.

#include "tests/support/element_assembly.hpp"
#include "tests/support/laws.hpp"
#include "voxelize/bricks.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace elastogen {
namespace {

constexpr double kH = 0.5;  // voxel edge [m]

VoxelData<double> voxel(Law law, double poisson) {
  return test::voxel_data(
      test::box_scene(1, 1, 1, kH, {"test", law, 1, poisson, 1}, Hourglass::kFull), 0);
}

/// The voxel as an octant of a cube: the three faces through corner 0 keep their planes.
std::map<int, double> octant() {
  std::map<int, double> held;
  for (int k = 0; k < 24; ++k)
    if (!(k / 3 >> k % 3 & 1)) held[k] = 0;
  return held;
}

/// Energy of the voxel less the work of the loads at u, and its gradient.
double potential(const VoxelData<double>& v, const Eigen::VectorXd& load, const Eigen::VectorXd& u,
                 double corner[3][8], Eigen::VectorXd& gradient) {
  double f[3][8];
  for (int k = 0; k < 24; ++k) corner[k % 3][k / 3] = u(k);
  const VoxelEnergy<double> energy = voxel_energy<true>(v, corner, f);
  gradient = -load;
  for (int k = 0; k < 24; ++k) gradient(k) += f[k % 3][k / 3];
  return energy.elastic + energy.hourglass - load.dot(u);
}

/// Newton's method from F = `start` for the equilibrium with the nominal stress P as dead loads on
/// the faces. Returns the F of that state.
Mat3<double> loaded(const VoxelData<double>& v, const Mat3<double>& P, const Mat3<double>& start,
                    const std::map<int, double>& held) {
  // the start, and the loads on the corners of each face
  Eigen::VectorXd u = Eigen::VectorXd::Zero(24), load = u, g, trial_g;
  for (int k = 0; k < 24; ++k)
    for (int i = k % 3, j = 0; j < 3; ++j) {
      const int side = k / 3 >> j & 1;
      u(k) += (start(i, j) - (i == j)) * side * kH;
      load(k) += P(i, j) * (side ? 1 : -1) * kH * kH / 4;  // a quarter of each face
    }
  double corner[3][8];
  double value = potential(v, load, u, corner, g);
  // a step is halved until the potential falls
  for (int k = 0; k < 60; ++k) {
    const Tangent<double> tangent = voxel_tangent<true>(v, corner);
    const Eigen::MatrixXd K = test::corner_matrix(
        [&](const double p[3][8], double q[3][8]) { voxel_hessian<true>(v, tangent, p, q); });
    const Eigen::VectorXd step = test::solve(K.sparseView(), -g, held);
    for (double a = 1; a > 1e-3; a /= 2) {
      const Eigen::VectorXd trial = u + a * step;
      const double next = potential(v, load, trial, corner, trial_g);
      if (next > value + 1e-15) continue;
      u = trial, value = next, g = trial_g;
      break;
    }
  }
  // F from the edges at corner 0
  Mat3<double> F;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) F(i, j) = (u(3 * (1 << j) + i) - u(i)) / kH + (i == j);
  return F;
}

Mat3<double> diagonal(double a, double b, double c) {
  return {{a, 0, 0, 0, b, 0, 0, 0, c}};
}

TEST(DeadLoad, AxialForceGivesTheStretchesOfTheLaw) {
  // E = 1, nu = 0.3; nominal stress and lateral stretch: roots of t_2 = 0 of the textbook energies
  struct Row {
    Law law;
    double stretch, P, lateral;
  };
  std::vector<Row> rows = {{Law::kNeoHookean, 0.7, -0.405230, 1.107935},
                           {Law::kNeoHookean, 1.5, 0.378280, 0.880175},
                           {Law::kNeoHookean, 2.0, 0.646745, 0.798078},
                           {Law::kStableNeoHookean, 0.7, -0.372900, 1.085299},
                           {Law::kStableNeoHookean, 1.5, 0.404446, 0.867086},
                           {Law::kStableNeoHookean, 2.0, 0.732113, 0.771045},
                           {Law::kFixedCorotated, 0.7, -0.343171, 1.093536},
                           {Law::kFixedCorotated, 1.5, 0.442869, 0.869332},
                           {Law::kFixedCorotated, 2.0, 0.836684, 0.773170}};
  for (const double a : {0.9, 1.1, 1.5, 2.0})
    rows.push_back({Law::kStvk, a, a * (a * a - 1) / 2, std::sqrt(1 - 0.3 * (a * a - 1))});
  for (const double a : {0.7, 0.9, 1.1, 1.5})
    rows.push_back({Law::kHencky, a, std::log(a) / a, std::pow(a, -0.3)});
  for (const Row& row : rows) {
    const Mat3<double> start = diagonal(1 + 0.97 * (row.stretch - 1), 1, 1);
    const Mat3<double> F = loaded(voxel(row.law, 0.3), diagonal(row.P, 0, 0), start, octant());
    const double digits = 1e-5;  // P of the tables has six
    EXPECT_NEAR(F(0, 0), row.stretch, digits) << law_name(row.law);
    EXPECT_NEAR(F(1, 1), row.lateral, digits) << law_name(row.law) << ' ' << row.stretch;
    EXPECT_NEAR(F(2, 2), row.lateral, digits) << law_name(row.law) << ' ' << row.stretch;
  }
}

TEST(DeadLoad, EqualForcesOnAllFacesGiveTheVolumeOfTheLaw) {
  // t of the textbook energies at three equal stretches a; E = 1, nu = 0.3
  const double mu = 1 / 2.6, lambda = 0.3 / (1.3 * 0.4), a = 1.1, J = a * a * a;
  const auto stress = [&](const Law& law) {
    const double m = 4 * mu / 3, l = lambda + 5 * mu / 6, I = 3 * a * a;
    switch (law.kind) {
      case Law::Kind::kFixedCorotated:
        return 2 * mu * (a - 1) + lambda * (J - 1) * a * a;
      case Law::Kind::kNeoHookean:
        return mu * (a - 1 / a) + lambda * std::log(J) / a;
      case Law::Kind::kStvk:
        return a * (2 * mu + 3 * lambda) * (a * a - 1) / 2;
      case Law::Kind::kStableNeoHookean:
        return m * a * I / (I + 1) + l * (J - 1 - 3 * m / (4 * l)) * a * a;
      default:  // those with K/2 (ln J)^2, K = lambda + 2 mu/3
        return (2 * mu + 3 * lambda) * std::log(a) / a;
    }
  };
  for (const Law law : test::kLaws) {
    const double P = stress(law);
    const Mat3<double> F =
        loaded(voxel(law, 0.3), diagonal(P, P, P), diagonal(1.08, 1.08, 1.08), octant());
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(F(i, i), a, 1e-9) << law_name(law);
  }
}

TEST(DeadLoad, SmallLoadsFindBulkAndShearModulusSeparately) {
  constexpr double kStress = 1e-7;  // of E
  for (const Law law : test::kLaws)
    for (const double poisson : {0.0, 0.32, 0.45}) {
      const Mat3<double> one = identity<double>();
      const Mat3<double> bulk =
          loaded(voxel(law, poisson), diagonal(kStress, kStress, kStress), one, octant());
      EXPECT_NEAR((bulk(0, 0) - 1) / kStress, 1 - 2 * poisson, 1e-6) << law_name(law);
      // the edge from corner 0 to 1 stays on the x axis, corner 2 in its plane
      const std::map<int, double> three_corners = {{0, 0}, {1, 0}, {2, 0}, {4, 0}, {5, 0}, {8, 0}};
      const Mat3<double> P = {{0, kStress, 0, kStress, 0, 0, 0, 0, 0}};
      const Mat3<double> shear = loaded(voxel(law, poisson), P, one, three_corners);
      EXPECT_NEAR((shear(0, 1) + shear(1, 0)) / kStress, 2 * (1 + poisson), 1e-6) << law_name(law);
    }
}

}  // namespace
}  // namespace elastogen
