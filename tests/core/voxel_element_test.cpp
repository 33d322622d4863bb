// SPDX-License-Identifier: Apache-2.0
// One voxel with its material: energy, forces, Hessians, zero modes, rigid motion.

#include "tests/support/eigenvalues.hpp"
#include "tests/support/element_assembly.hpp"
#include "tests/support/laws.hpp"
#include "tests/support/matrices.hpp"

#include <gtest/gtest.h>

namespace elastogen {
namespace {

using test::Random;

constexpr Hourglass kModes[3] = {Hourglass::kFull, Hourglass::kVariance, Hourglass::kOff};

/// A voxel of edge 0.5 with E = 1: full, or cut with unequal weights and a turned rotation.
VoxelData<double> voxel(Law law, Hourglass hourglass, bool border, Random& random) {
  VoxelData<double> v{};
  v.law = test::parameters<double>(law, 1, 0.3);
  v.h = 0.5, v.hourglass = hourglass, v.phi = border ? 0.4 : 1;
  std::uniform_real_distribution<double> unit(0, 1);
  double mean[8], place[3];
  for (double& p : place) p = unit(random);
  for (int c = 0; c < 8; ++c) {
    mean[c] = 1;
    for (int d = 0; d < 3; ++d) mean[c] *= c >> d & 1 ? place[d] : 1 - place[d];
  }
  hex8::fill_moments(mean, v.M);
  for (int p = 0; p < 7; ++p) v.M[p] = border ? v.M[p] : 0;
  for (double& c : v.c) c = border ? 0.3 + 0.1 * unit(random) : 0.4;
  const Mat3<double> R = border ? test::rotation(random) : identity<double>();
  std::copy(R.m, R.m + 9, v.R);
  return v;
}

/// Corner displacement of x = F X and noise.
void displace(const Mat3<double>& F, double noise, Random& random, double u[3][8]) {
  std::normal_distribution<double> normal;
  for (int c = 0; c < 8; ++c)
    for (int i = 0; i < 3; ++i) {
      u[i][c] = noise * normal(random);
      for (int d = 0; d < 3; ++d) u[i][c] += (F(i, d) - (i == d)) * (c >> d & 1 ? 0.25 : -0.25);
    }
}

double total(const VoxelEnergy<double>& e) {
  return e.elastic + e.hourglass;
}

TEST(VoxelElement, ForceIsTheDerivativeOfTheEnergyForEveryLawAndBorder) {
  Random random(1);
  constexpr double d = 1e-6;
  for (const Law law : test::kLaws)
    for (const Hourglass mode : kModes) {
      const VoxelData<double> v = voxel(law, mode, true, random);
      double u[3][8], f[3][8], ignored[3][8];
      displace(test::stretched(1.4, 1, 0.7, random), 0.02, random, u);
      voxel_energy<true>(v, u, f);
      for (int k = 0; k < 24; ++k) {
        double& entry = u[k % 3][k / 3];
        const double middle = entry;
        entry = middle + d;
        const double up = total(voxel_energy<true>(v, u, ignored));
        entry = middle - d;
        const double down = total(voxel_energy<true>(v, u, ignored));
        entry = middle;
        ASSERT_NEAR(f[k % 3][k / 3], (up - down) / (2 * d), 1e-9) << law_name(law);
      }
    }
}

/// The Hessian by its tangent at u against differences of the force.
void expect_derivative_of_force(const VoxelData<double>& v, double u[3][8], TangentKind kind,
                                double bound) {
  constexpr double d = 1e-5;
  double up[3][8], down[3][8];
  const Tangent<double> tangent = voxel_tangent<true>(v, u, kind);
  const Eigen::MatrixXd K = test::corner_matrix(
      [&](const double p[3][8], double f[3][8]) { voxel_hessian<true>(v, tangent, p, f); });
  EXPECT_LE((K - K.transpose()).norm(), 1e-13 * K.norm());
  for (int col = 0; col < 24; ++col) {
    double& entry = u[col % 3][col / 3];
    const double middle = entry;
    entry = middle + d;
    voxel_energy<true>(v, u, up);
    entry = middle - d;
    voxel_energy<true>(v, u, down);
    entry = middle;
    for (int row = 0; row < 24; ++row)
      ASSERT_NEAR(K(row, col), (up[row % 3][row / 3] - down[row % 3][row / 3]) / (2 * d), bound);
  }
}

TEST(VoxelElement, HessianIsTheDerivativeOfTheForceWhereItIsDefinite) {
  Random random(2);
  for (const Law law : test::kLaws) {
    SCOPED_TRACE(law_name(law));
    const VoxelData<double> v = voxel(law, Hourglass::kFull, true, random);
    double u[3][8];
    displace(test::stretched(1.05, 1.03, 1.01, random), 0, random, u);
    expect_derivative_of_force(v, u, TangentKind::kProjected, 1e-7);
  }
}

TEST(VoxelElement, TrueHessianIsTheDerivativeOfTheForceWhereItIsNot) {
  Random random(6);
  for (const Law law : test::kLaws) {
    SCOPED_TRACE(law_name(law));
    const VoxelData<double> v = voxel(law, Hourglass::kFull, true, random);
    double u[3][8];
    displace(test::stretched(0.5, 0.8, 0.7, random), 0.02, random, u);
    const Tangent<double> whole = voxel_tangent<true>(v, u, TangentKind::kTrue);
    const Tangent<double> part = voxel_tangent<true>(v, u);
    EXPECT_FALSE(std::equal(whole.m, whole.m + 45, part.m));
    expect_derivative_of_force(v, u, TangentKind::kTrue, 1e-6);
  }
}

TEST(VoxelElement, RestHessianIsThatOfEveryLawAtRest) {
  Random random(3);
  for (const Law law : test::kLaws) {
    const VoxelData<double> v = voxel(law, Hourglass::kFull, true, random);
    const double rest[3][8] = {};
    const Tangent<double> tangent = voxel_tangent<true>(v, rest);
    const Eigen::MatrixXd K = test::corner_matrix(
        [&](const double p[3][8], double f[3][8]) { voxel_hessian<true>(v, tangent, p, f); });
    EXPECT_LE((K - test::rest_stiffness(v)).norm(), 1e-13 * K.norm()) << law_name(law);
  }
}

TEST(VoxelElement, FullVoxelIsABorderVoxelWithoutMoments) {
  Random random(4);
  const VoxelData<double> v = voxel(Law::kNeoHookean, Hourglass::kFull, false, random);
  double u[3][8], f[3][8], g[3][8];
  displace(test::stretched(1.4, 1, 0.7, random), 0.05, random, u);
  EXPECT_EQ(total(voxel_energy<false>(v, u, f)), total(voxel_energy<true>(v, u, g)));
  for (int i = 0; i < 3; ++i)
    for (int c = 0; c < 8; ++c) EXPECT_EQ(f[i][c], g[i][c]);
}

TEST(VoxelElement, StiffnessHasSixZeroModesAndEighteenWithoutTheVarianceTerm) {
  Random random(5);
  for (const bool border : {false, true})
    for (const Hourglass mode : kModes) {
      const Eigen::MatrixXd K = test::rest_stiffness(voxel(Law::kNeoHookean, mode, border, random));
      const Eigen::VectorXd values = test::eigenvalues(K);
      EXPECT_LE((K - K.transpose()).norm(), 1e-14 * K.norm());
      EXPECT_GE(values(0), -1e-14 * K.norm());
      const int zeros = int((values.array() < 1e-10 * K.norm()).count());
      EXPECT_EQ(zeros, mode == Hourglass::kOff ? 18 : 6) << border;
    }
}

TEST(VoxelElement, FreeBodyHasSixZeroModes) {
  Material material;
  const Scene scene = test::box_scene(3, 2, 1, 0.1, material);
  const Eigen::MatrixXd K = test::rest_stiffness(scene);
  const Eigen::VectorXd values = test::eigenvalues(K);
  EXPECT_EQ((values.array() < 1e-10 * K.norm()).count(), 6);
}

TEST(VoxelElement, RigidMotionIsFreeOfEnergyAndForceAlsoFarAway) {
  Random random(6);
  for (const Law law : test::kLaws)
    for (const Hourglass mode : {Hourglass::kFull, Hourglass::kVariance})
      for (const double shift : {0.0, 1e6}) {
        const VoxelData<double> v = voxel(law, mode, true, random);
        double u[3][8], f[3][8];
        displace(test::rotation(random), 0, random, u);
        for (int c = 0; c < 8; ++c) u[1][c] += shift;
        // a position of 1e6 edges carries a noise of eps 1e6 edges, which is strain
        const double noise = 1e-14 + 1e-15 * shift;
        EXPECT_LE(total(voxel_energy<true>(v, u, f)), 100 * noise * noise);
        for (int i = 0; i < 3; ++i)
          for (int c = 0; c < 8; ++c) EXPECT_NEAR(f[i][c], 0, 10 * noise) << law_name(law);
      }
}

struct Balance {
  double force = 0, torque = 0, size = 0;
};

/// Net force and torque of a voxel's forces at x = X + u.
Balance balance(const VoxelData<double>& v, const double u[3][8]) {
  double f[3][8], x[3][8], force[3] = {}, torque[3] = {};
  voxel_energy<true>(v, u, f);
  Balance b;
  for (int c = 0; c < 8; ++c)
    for (int i = 0; i < 3; ++i) {
      x[i][c] = u[i][c] + (c >> i & 1 ? 0.25 : -0.25);
      b.size += std::abs(f[i][c]);
      force[i] += f[i][c];
    }
  for (int c = 0; c < 8; ++c)
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      torque[i] += x[j][c] * f[k][c] - x[k][c] * f[j][c];
    }
  b.force = std::hypot(force[0], force[1], force[2]);
  b.torque = std::hypot(torque[0], torque[1], torque[2]);
  return b;
}

TEST(VoxelElement, NetForceVanishesAndTorqueTooWithTheVarianceTerm) {
  Random random(7);
  for (const Law law : test::kLaws)
    for (int k = 0; k < 50; ++k)
      for (const Hourglass mode : kModes) {
        const VoxelData<double> v = voxel(law, mode, k % 2, random);
        double u[3][8];
        displace(test::stretched(1.4, 1, 0.7, random), 0.05, random, u);
        const Balance b = balance(v, u);
        ASSERT_LE(b.force, 1e-12 * b.size) << law_name(law);
        if (mode == Hourglass::kFull) continue;
        ASSERT_LE(b.torque, 1e-12 * b.size) << law_name(law);
      }
}

TEST(VoxelElement, PacksOfFloatDoWhatScalarsOfDoubleDo) {
  Random random(8);
  for (const Law law : test::kLaws) {
    const VoxelData<double> v = voxel(law, Hourglass::kFull, true, random);
    // one voxel in all lanes, with other displacements in each
    VoxelData<Pack<float>> p{};
    using P = Pack<float>;
    p.law = {law, float(v.law.mu), float(v.law.lambda)};
    p.h = float(v.h), p.hourglass = v.hourglass, p.phi = constant<P>(float(v.phi));
    for (int k = 0; k < 4; ++k) p.c[k] = constant<P>(float(v.c[k]));
    for (int k = 0; k < 7; ++k) p.M[k] = constant<P>(float(v.M[k]));
    for (int k = 0; k < 9; ++k) p.R[k] = constant<P>(float(v.R[k]));
    double u[kLanes][3][8];
    P packed[3][8], f[3][8];
    for (int lane = 0; lane < kLanes; ++lane) {
      displace(test::stretched(1.3, 1, 0.8, random), 0.02, random, u[lane]);
      for (int i = 0; i < 3; ++i)
        for (int c = 0; c < 8; ++c) packed[i][c][lane] = float(u[lane][i][c]);
    }
    const VoxelEnergy<P> energy = voxel_energy<true>(p, packed, f);
    // each lane against the scalar in double
    for (int lane = 0; lane < kLanes; ++lane) {
      double exact[3][8];
      const VoxelEnergy<double> reference = voxel_energy<true>(v, u[lane], exact);
      EXPECT_NEAR(energy.elastic[lane], reference.elastic, 1e-6) << law_name(law);
      EXPECT_NEAR(energy.hourglass[lane], reference.hourglass, 1e-6) << law_name(law);
      EXPECT_NEAR(energy.J[lane], reference.J, 1e-5) << law_name(law);
      for (int i = 0; i < 3; ++i)
        for (int c = 0; c < 8; ++c) EXPECT_NEAR(f[i][c][lane], exact[i][c], 1e-5) << law_name(law);
    }
  }
}

}  // namespace
}  // namespace elastogen
