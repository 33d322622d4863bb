// SPDX-License-Identifier: Apache-2.0
// The voxel element against quadrature, against isotropic elasticity, and against the network's.

#include "mpm_fem/fem/voxel_element.hpp"

#include "core/polar.hpp"
#include "tests/mpm_fem/bodies.hpp"
#include "tests/support/eigenvalues.hpp"
#include "tests/support/element_assembly.hpp"
#include "tests/support/laws.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace elastogen {
namespace {

using test::ElasticBody;
using test::Element;
using test::ElementMesh;
using test::Random;

constexpr double kEdge = 0.5;

/// A full voxel of edge 0.5 with the variance weight c for all patterns.
ElementMesh full_voxel(Element element, Hourglass hourglass, double c) {
  const Scene scene = test::voxel_scene(make_box(1, 1, 1, kEdge), test::solid(), hourglass);
  ElementMesh mesh = fem::voxel_mesh(scene, element);
  mesh.variance.fill(c);
  return mesh;
}

/// F of the trilinear field with corner displacements u, at X in units of the edge.
Mat3<double> gradient_at(const Array<double>& u, const Vec3& X) {
  Mat3<double> F = identity<double>();
  for (int c = 0; c < 8; ++c)
    for (int d = 0; d < 3; ++d) {
      double slope = 1 / kEdge;
      for (int k = 0; k < 3; ++k) {
        const bool upper = c >> k & 1;
        slope *= k == d ? (upper ? 1 : -1) : (upper ? X[size_t(k)] : 1 - X[size_t(k)]);
      }
      for (int i = 0; i < 3; ++i) F(i, d) += u(c, i) * slope;
    }
  return F;
}

/// visit(X, weight) over the 2x2x2 Gauss points of the box [0, upper] in units of the edge.
template <class Visit>
void for_gauss_points(const Vec3& upper, const Visit& visit) {
  const double place[2] = {0.5 - std::sqrt(1 / 12.0), 0.5 + std::sqrt(1 / 12.0)};
  for (int k = 0; k < 8; ++k)
    visit(Vec3{upper[0] * place[k & 1], upper[1] * place[k >> 1 & 1], upper[2] * place[k >> 2]},
          1 / 8.0);
}

TEST(VoxelElement, EnergyOfAFullVoxelIsThatOfItsCentreAndTheVarianceOfF) {
  // c/2 times the integral of |F - F_centre|^2, by quadrature that is exact for it
  constexpr double kWeight = 0.7, kVolume = kEdge * kEdge * kEdge;
  Random random(1);
  const Material m = test::solid(Law::kStvk);
  const ElasticBody body(full_voxel(Element::kVoxel, Hourglass::kVariance, kWeight), {m});
  for (int sample = 0; sample < 10; ++sample) {
    const Array<double> u =
        test::displaced(body.mesh(), test::stretched(1.2, 1, 0.8, random), 0.1, random);
    const Mat3<double> centre = gradient_at(u, {0.5, 0.5, 0.5});
    double variance = 0;
    for_gauss_points({1, 1, 1}, [&](const Vec3& X, double weight) {
      const double distance = test::distance(gradient_at(u, X), centre);
      variance += weight * kWeight / 2 * kVolume * distance * distance;
    });
    // psi = mu |e|^2 + lambda/2 (tr e)^2, e = (F^T F - 1)/2
    const Mat3<double> C = transposed_times(centre, centre);
    double square = 0, trace = 0;
    for (int k = 0; k < 9; ++k) {
      const double e = (C.m[k] - (k % 4 == 0)) / 2;
      square += e * e, trace += k % 4 == 0 ? e : 0;
    }
    const EnergyParts parts = body.energy(u);
    EXPECT_NEAR(parts.hourglass / variance, 1, 1e-13);
    EXPECT_NEAR(parts.elastic / (kVolume * (m.mu() * square + m.lambda() / 2 * trace * trace)), 1,
                1e-12);
  }
}

TEST(VoxelElement, GradientOfAPartlyFilledVoxelIsTheMeanOverTheFill) {
  // filled are the lower 0.6 along x and 0.3 along z
  const Vec3 filled = {0.6, 1, 0.3};
  VoxelGrid grid = make_box(1, 1, 1, kEdge);
  grid.fill.fill(filled[0] * filled[1] * filled[2]);
  for (int c = 0; c < 8; ++c) {
    grid.shape_mean(0, c) = 1;
    for (int d = 0; d < 3; ++d)
      grid.shape_mean(0, c) *= c >> d & 1 ? filled[size_t(d)] / 2 : 1 - filled[size_t(d)] / 2;
  }
  const Scene scene = test::voxel_scene(grid, test::solid());
  const ElasticBody body(fem::voxel_mesh(scene, Element::kVoxel), scene.materials);
  Random random(2);
  const Array<double> u = test::displaced(body.mesh(), test::gaussian(random), 0.1, random);
  Mat3<double> mean{};
  for_gauss_points(filled, [&](const Vec3& X, double weight) {
    const Mat3<double> F = gradient_at(u, X);
    for (int k = 0; k < 9; ++k) mean.m[k] += weight * F.m[k];
  });
  const Array<double> F = body.deformation_gradient(u);
  for (int k = 0; k < 9; ++k) EXPECT_NEAR(F(0, k), mean.m[k], 1e-14);
}

TEST(VoxelElement, TwistCostsWhatIsotropicElasticityChargesForIt) {
  // the modes yz of x, zx of y, xy of z: full integration is exact for them
  const Material m = test::solid(Law::kNeoHookean, 1, 0.3);
  const Array<double> rest(8, 3);
  const Eigen::MatrixXd K = test::element_hessian(
      {full_voxel(Element::kVoxel, Hourglass::kFull, 0.7), {m}}, 0, rest, TangentKind::kTrue);
  const Eigen::MatrixXd full = test::element_hessian(
      {full_voxel(Element::kHex, Hourglass::kFull, 0.7), {m}}, 0, rest, TangentKind::kTrue);
  Eigen::MatrixXd modes = Eigen::MatrixXd::Zero(24, 3);
  for (int c = 0; c < 8; ++c)
    for (int d = 0; d < 3; ++d) {
      const int e = (d + 1) % 3, f = (d + 2) % 3;
      modes(3 * c + d, d) = (c >> e & 1 ? 1 : -1) * (c >> f & 1 ? 1 : -1);
    }
  const Eigen::Matrix3d charged = modes.transpose() * K * modes;
  EXPECT_LE((charged - modes.transpose() * full * modes).norm(), 1e-14 * charged.norm());
}

TEST(VoxelElement, HessianAtRestTurnsWithTheFrozenRotation) {
  Random random(3);
  const ElementMesh mesh = test::one_voxel(random, Hourglass::kFull);
  ElasticBody body(mesh, {test::solid()});
  const Eigen::MatrixXd K = test::element_hessian(body, 0, Array<double>(8, 3), TangentKind::kTrue);
  const Mat3<double> R = test::rotation(random);
  const Array<double> turned = test::displaced(mesh, R, 0, random);
  body.freeze_rotations(turned);
  Eigen::MatrixXd Q = Eigen::MatrixXd::Zero(24, 24);
  for (int c = 0; c < 8; ++c)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) Q(3 * c + i, 3 * c + j) = R(i, j);
  const Eigen::MatrixXd H = test::element_hessian(body, 0, turned, TangentKind::kTrue);
  EXPECT_LE((H - Q * K * Q.transpose()).norm(), 1e-13 * K.norm());
}

TEST(VoxelElement, VarianceWithTorsionHasNoNegativeEigenvalueForAnyWeights) {
  Random random(4);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int sample = 0; sample < 100; ++sample) {
    ElementMesh mesh = test::one_voxel(random, Hourglass::kFull);
    // from none to far above mu
    for (int k = 0; k < 4; ++k) mesh.variance(0, k) = sample % 4 ? std::pow(10, unit(random)) : 0;
    const Mat3<double> R = test::rotation(random);
    Eigen::MatrixXd K = Eigen::MatrixXd::Zero(24, 24);
    fem::add_hourglass_hessian(fem::voxel_hourglass(mesh, 0, 0.4, R.m), K.data());
    EXPECT_GE(test::eigenvalues(K)(0), -1e-15 * K.norm());
  }
}

TEST(VoxelElement, GoesWithoutTorsionWhereTheRotationIsNotUnique) {
  Random random(5);
  const ElementMesh mesh = test::one_voxel(random, Hourglass::kFull);
  ElementMesh plain = mesh;
  plain.hourglass = Hourglass::kVariance;
  ElasticBody body(mesh, {test::solid()});
  body.freeze_rotations(test::displaced(mesh, test::stretched(1.5, 0, 0, random), 0, random));
  const Array<double> u = test::displaced(mesh, test::stretched(1.2, 1, 0.8, random), 0.1, random);
  const double E = ElasticBody(plain, {test::solid()}).energy(u).hourglass;
  EXPECT_NEAR(body.energy(u).hourglass / E, 1, 1e-14);
  body.freeze_rotations(u);
  EXPECT_GE(std::abs(body.energy(u).hourglass / E - 1), 1e-3);
}

/// A box of voxels with random fills, centroids, and a sheet one voxel thick at its side.
Scene ragged_scene(Random& random, Hourglass hourglass, Law law) {
  std::uniform_real_distribution<double> unit(0.1, 0.9);
  VoxelGrid grid = make_box(3, 3, 1, kEdge);
  for (int64_t v = 0; v < grid.voxel_count(); ++v) {
    grid.fill(v) = unit(random);
    const double place[3] = {unit(random), unit(random), unit(random)};
    for (int c = 0; c < 8; ++c) {
      grid.shape_mean(v, c) = 1;
      for (int d = 0; d < 3; ++d) grid.shape_mean(v, c) *= c >> d & 1 ? place[d] : 1 - place[d];
    }
  }
  return test::voxel_scene(grid, test::solid(law), hourglass);
}

constexpr Hourglass kModes[3] = {Hourglass::kFull, Hourglass::kVariance, Hourglass::kOff};

TEST(VoxelElement, StiffnessAtRestIsThatOfTheNetworksElement) {
  Random random(6);
  for (const Hourglass mode : kModes) {
    const Scene scene = ragged_scene(random, mode, Law::kHencky);
    const ElasticBody body(fem::voxel_mesh(scene, Element::kVoxel), scene.materials);
    const Array<double> rest(body.mesh().rest.rows(), 3);
    for (int64_t v = 0; v < scene.grid.voxel_count(); ++v) {
      const Eigen::MatrixXd K = test::rest_stiffness(test::voxel_data(scene, v));
      EXPECT_LE((test::element_hessian(body, v, rest, TangentKind::kTrue) - K).norm(),
                1e-14 * K.norm());
    }
  }
}

TEST(VoxelElement, EnergyAndForcesAreThoseOfTheNetworksElement) {
  Random random(7);
  for (const Law law : test::kLaws)
    for (const Hourglass mode : kModes) {
      const Scene scene = ragged_scene(random, mode, law);
      ElasticBody body(fem::voxel_mesh(scene, Element::kVoxel), scene.materials);
      const ElementMesh& mesh = body.mesh();
      // rotations are frozen in one state, the energy is that of another
      const Array<double> before =
          test::displaced(mesh, test::stretched(1.1, 1, 0.9, random), 0.1, random);
      const Array<double> u =
          test::displaced(mesh, test::stretched(1.3, 1, 0.7, random), 0.1, random);
      body.freeze_rotations(before);
      const Array<double> F = body.deformation_gradient(before);
      EnergyParts sum;
      Eigen::VectorXd g = Eigen::VectorXd::Zero(u.size());
      // the network's element, voxel by voxel
      for (int64_t v = 0; v < mesh.elements.rows(); ++v) {
        VoxelData<double> data = test::voxel_data(scene, v);
        Mat3<double> Fv;
        std::copy(F.row(v), F.row(v) + 9, Fv.m);
        const Mat3<double> R = polar_rotation(Fv);
        std::copy(R.m, R.m + 9, data.R);
        double corner[3][8], f[3][8];
        test::gather(scene.grid, v, test::vector_of(u), corner);
        const VoxelEnergy<double> energy = voxel_energy<true>(data, corner, f);
        sum.elastic += energy.elastic, sum.hourglass += energy.hourglass;
        for (int c = 0; c < 8; ++c)
          for (int i = 0; i < 3; ++i) g(3 * mesh.elements(v, c) + i) += f[i][c];
      }
      // totals agree to rounding
      const EnergyParts parts = body.energy(u);
      EXPECT_NEAR(parts.elastic, sum.elastic, 1e-13 * sum.elastic) << law_name(law);
      EXPECT_NEAR(parts.hourglass, sum.hourglass, 1e-13 * sum.hourglass) << law_name(law);
      EXPECT_LE((test::gradient(body, u) - g).norm(), 1e-13 * g.norm()) << law_name(law);
    }
}

}  // namespace
}  // namespace elastogen
