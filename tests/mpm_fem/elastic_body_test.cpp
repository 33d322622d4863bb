// SPDX-License-Identifier: Apache-2.0
// Properties of every element: rigid motions, zero modes, balance, objectivity, uniform states.

#include "core/parallel.hpp"
#include "tests/mpm_fem/bodies.hpp"
#include "tests/support/eigenvalues.hpp"
#include "tests/support/laws.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace elastogen {
namespace {

using test::ElasticBody;
using test::Element;
using test::ElementMesh;
using test::Random;

/// A block with moved inner nodes; cubes where the element is the voxel.
ElementMesh any_block(Element element, int n, double h) {
  if (element != Element::kVoxel) return test::block(element, n, n, n, h, 0.2);
  return fem::voxel_mesh(test::voxel_scene(make_box(n, n, n, h), test::solid()), element);
}

TEST(ElasticBody, RigidMotionIsFreeOfEnergyAndForceAlsoFarAway) {
  Random random(1);
  for (const Element element : test::kAllElements)
    for (const Law law : test::kLaws)
      for (const double shift : {0.0, 1e6}) {
        const ElasticBody body(test::one_element(element, random), {test::solid(law)});
        Array<double> u = test::displaced(body.mesh(), test::rotation(random), 0, random);
        for (int64_t n = 0; n < u.rows(); ++n) u(n, 1) += shift;
        // a displacement of 1e6 carries a noise of eps 1e6, which is strain
        const double noise = 1e-14 + 1e-15 * shift;
        EXPECT_LE(test::energy(body, u), 100 * noise * noise) << fem::element_name(element);
        EXPECT_LE(test::gradient(body, u).lpNorm<Eigen::Infinity>(), 10 * noise);
      }
}

TEST(ElasticBody, ATranslationIsFreeToTheBit) {
  Random random(2);
  for (const Element element : test::kAllElements) {
    const ElasticBody body(test::one_element(element, random), {test::solid()});
    Array<double> u(body.mesh().rest.rows(), 3);
    u.fill(1e9 / 3);
    EXPECT_EQ(test::energy(body, u), 0);
    EXPECT_EQ(test::gradient(body, u).norm(), 0);
  }
}

int zero_modes(const ElasticBody& body) {
  const Array<double> rest(body.mesh().rest.rows(), 3);
  const Eigen::MatrixXd K = test::hessian(body, rest);
  const Eigen::VectorXd values = test::eigenvalues(K);
  EXPECT_GE(values(0), -1e-13 * K.norm());
  return int((values.array() < 1e-10 * K.norm()).count());
}

TEST(ElasticBody, StiffnessAtRestHasSixZeroModesAndEighteenOfAVoxelWithoutTheVarianceTerm) {
  // of tet10 with mean dilatation three conformal ones besides (fem/mean_dilatation.hpp)
  Random random(3);
  for (const Element element : test::kAllElements)
    EXPECT_EQ(zero_modes({test::one_element(element, random), {test::solid()}}),
              element == Element::kTet10Bbar ? 9 : 6)
        << fem::element_name(element);
  EXPECT_EQ(zero_modes({test::one_voxel(random, Hourglass::kVariance), {test::solid()}}), 6);
  EXPECT_EQ(zero_modes({test::one_voxel(random, Hourglass::kOff), {test::solid()}}), 18);
}

TEST(ElasticBody, StiffnessOfABlockHasSixZeroModes) {
  for (const Element element : test::kAllElements) {
    const bool is_voxel = element == Element::kVoxel;
    const ElementMesh mesh =
        is_voxel ? any_block(element, 2, 0.5) : test::block(element, 2, 1, 1, 1);
    EXPECT_EQ(zero_modes({mesh, {test::solid()}}), 6) << fem::element_name(element);
  }
}

TEST(ElasticBody, ConformalModesOfFewQuadraticTetrahedraGoAsTheirCentroidsLeaveTheLineAndThePlane) {
  // the six of a cube have their centroids in a plane
  const ElementMesh cube = test::block(Element::kTet4, 1, 1, 1, 1);
  EXPECT_EQ(zero_modes({test::quadratic(cube, Element::kTet10Bbar), {test::solid()}}), 6 + 1);
  EXPECT_EQ(zero_modes({test::quadratic(cube, Element::kTet10), {test::solid()}}), 6);

  // the first of them and the one that shares three of its corners
  const auto common = [&](int64_t e) {
    int count = 0;
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < 4; ++b) count += cube.elements(0, a) == cube.elements(e, b);
    return count;
  };
  int64_t other = 1;
  while (common(other) != 3) ++other;
  std::vector<int32_t> nodes(cube.elements.row(0), cube.elements.row(0) + 4);
  nodes.insert(nodes.end(), cube.elements.row(other), cube.elements.row(other) + 4);
  ElementMesh pair = cube;
  test::set_elements(pair, nodes);
  // the three corners that the two do not use are free besides
  const ElasticBody body(test::quadratic(pair, Element::kTet10Bbar), {test::solid()});
  EXPECT_EQ(zero_modes(body), 6 + 2 + 3 * 3);
}

TEST(ElasticBody, StiffnessAtRestIsThatOfEveryLaw) {
  Random random(4);
  for (const Element element : test::kAllElements) {
    const ElementMesh mesh = test::one_element(element, random);
    const Array<double> rest(mesh.rest.rows(), 3);
    const Eigen::MatrixXd K =
        test::element_hessian({mesh, {test::solid(Law::kStvk)}}, 0, rest, TangentKind::kTrue);
    for (const Law law : test::kLaws) {
      const ElasticBody body(mesh, {test::solid(law)});
      EXPECT_LE((test::element_hessian(body, 0, rest, TangentKind::kTrue) - K).norm(),
                1e-13 * K.norm())
          << fem::element_name(element) << ' ' << law_name(law);
    }
  }
}

/// Largest of net force and torque [m] over the sum of all forces.
double imbalance(const ElasticBody& body, const Array<double>& u) {
  const Array<double> g = test::array_of(test::gradient(body, u));
  double force[3] = {}, torque[3] = {}, size = 0;
  for (int64_t n = 0; n < g.rows(); ++n)
    for (int d = 0; d < 3; ++d) {
      const int e = (d + 1) % 3, f = (d + 2) % 3;
      const double y = body.mesh().rest(n, e) + u(n, e), z = body.mesh().rest(n, f) + u(n, f);
      force[d] += g(n, d), torque[d] += y * g(n, f) - z * g(n, e), size += std::abs(g(n, d));
    }
  return std::max(std::hypot(force[0], force[1], force[2]),
                  std::hypot(torque[0], torque[1], torque[2])) /
         size;
}

TEST(ElasticBody, NetForceAndTorqueOfRandomStatesVanish) {
  // of the voxel with the variance term alone: the torsion correction's frozen rotation has a
  // torque
  Random random(5);
  double worst = 0;
  for (const Element element : test::kAllElements)
    for (const Law law : test::kLaws)
      for (int sample = 0; sample < 10; ++sample) {
        const ElasticBody body(test::one_element(element, random, Hourglass::kVariance),
                               {test::solid(law)});
        worst = std::max(worst, imbalance(body, test::inverted(body, random)));
        worst = std::max(
            worst,
            imbalance(body, test::displaced(body.mesh(), test::stretched(1.4, 1, 0.7, random), 0.1,
                                            random)));
      }
  printf("largest imbalance %.1e\n", worst);
  EXPECT_LE(worst, 1e-12);
}

TEST(ElasticBody, EnergyAndForcesTurnWithTheBody) {
  Random random(6);
  for (const Element element : test::kAllElements)
    for (const Law law : test::kLaws) {
      ElasticBody body(test::one_element(element, random), {test::solid(law)});
      const Mat3<double> Q = test::rotation(random);
      const Array<double> u =
          test::displaced(body.mesh(), test::stretched(1.3, 1, 0.8, random), 0.1, random);
      // the whole body turned by Q
      Array<double> turned(u.rows(), 3);
      for (int64_t n = 0; n < u.rows(); ++n)
        for (int i = 0; i < 3; ++i) {
          turned(n, i) = -body.mesh().rest(n, i);
          for (int j = 0; j < 3; ++j) turned(n, i) += Q(i, j) * (body.mesh().rest(n, j) + u(n, j));
        }
      // energies agree, and forces turn with the body
      body.freeze_rotations(u);
      const double E = test::energy(body, u);
      const Array<double> g = test::array_of(test::gradient(body, u));
      body.freeze_rotations(turned);
      EXPECT_NEAR(test::energy(body, turned), E, 1e-12 * E) << fem::element_name(element);
      const Array<double> h = test::array_of(test::gradient(body, turned));
      const double size = test::vector_of(g).norm();
      for (int64_t n = 0; n < u.rows(); ++n)
        for (int i = 0; i < 3; ++i)
          EXPECT_NEAR(h(n, i), Q(i, 0) * g(n, 0) + Q(i, 1) * g(n, 1) + Q(i, 2) * g(n, 2),
                      1e-12 * size)
              << fem::element_name(element) << ' ' << law_name(law);
    }
}

TEST(ElasticBody, UniformStateHasTheLawsEnergyAndStress) {
  // neo-Hookean: psi = mu/2 (I - 3) - mu ln J + lambda/2 ln^2 J, J sigma = mu (b - 1) + lambda ln J
  Random random(7);
  const Material m = test::solid(Law::kNeoHookean, 2.5, 0.3);
  for (const Element element : test::kAllElements) {
    const ElasticBody body(any_block(element, 2, 0.5), {m});
    const Mat3<double> F = test::stretched(1.5, 1.1, 0.6, random);
    const Mat3<double> b = times_transposed(F, F);
    const double J = determinant(F), I = b(0, 0) + b(1, 1) + b(2, 2), pressure = std::log(J);
    const Array<double> u = test::displaced(body.mesh(), F, 0, random);
    EXPECT_NEAR(test::energy(body, u),
                m.mu() * ((I - 3) / 2 - pressure) + m.lambda() / 2 * pressure * pressure, 1e-12);
    EXPECT_NEAR(body.min_j(u), J, 1e-13);
    const Array<double> gradient = body.deformation_gradient(u), sigma = body.cauchy_stress(u);
    for (int64_t e = 0; e < gradient.rows(); ++e) {
      for (int k = 0; k < 9; ++k) EXPECT_NEAR(gradient(e, k), F.m[k], 1e-13);
      for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3;
        EXPECT_NEAR(sigma(e, i), (m.mu() * (b(i, i) - 1) + m.lambda() * pressure) / J, 1e-12);
        EXPECT_NEAR(sigma(e, 3 + i), m.mu() * b(i, j) / J, 1e-12);
      }
    }
  }
}

TEST(ElasticBody, HexahedraOfAPartlyFilledVoxelWeighWithItsFill) {
  Random random(13);
  for (const Element element : {Element::kHex, Element::kHexBbar}) {
    ElementMesh partly = test::one_voxel(random, Hourglass::kFull);
    partly.element = element;
    const Array<double> u =
        test::displaced(partly, test::stretched(1.3, 1, 0.8, random), 0.1, random);
    const ElementMesh full = test::block(element, 1, 1, 1, 1);
    EXPECT_NEAR(test::energy({partly, {test::solid()}}, u),
                0.4 * test::energy({full, {test::solid()}}, u), 1e-15);
  }
}

TEST(ElasticBody, VolumeMeanOfTheGradientDependsOnTheBoundaryAlone) {
  Random random(8);
  const Mat3<double> F = test::stretched(1.5, 1.1, 0.6, random);
  std::normal_distribution<double> normal(0, 0.05);
  for (const Element element : test::kAllElements) {
    const ElasticBody body(any_block(element, 2, 0.5), {test::solid()});
    Array<double> u = test::displaced(body.mesh(), F, 0, random);
    for (int64_t n = 0; n < u.rows(); ++n)
      for (int d = 0; d < 3; ++d)
        if (!test::on_boundary(body.mesh(), n, 1)) u(n, d) += normal(random);
    const Array<double> gradient = body.deformation_gradient(u), volume = body.volume();
    for (int k = 0; k < 9; ++k) {
      double mean = 0;
      for (int64_t e = 0; e < volume.rows(); ++e) mean += volume(e) * gradient(e, k);
      EXPECT_NEAR(mean, F.m[k], 1e-13) << fem::element_name(element);
    }
  }
}

TEST(ElasticBody, StressOfASmallStateIsHookesOfTheMeanStrain) {
  Random random(9);
  const Material m = test::solid(Law::kStableNeoHookean, 2.5, 0.4);
  for (const Element element : test::kAllElements) {
    const ElasticBody body(test::one_element(element, random), {m});
    const Array<double> u = test::displaced(body.mesh(), identity<double>(), 1e-7, random);
    const Array<double> F = body.deformation_gradient(u), sigma = body.cauchy_stress(u);
    const double trace = F(0, 0) + F(0, 4) + F(0, 8) - 3;
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3;
      // of second order in strains of 1e-7
      EXPECT_NEAR(sigma(0, i), 2 * m.mu() * (F(0, 4 * i) - 1) + m.lambda() * trace, 1e-11);
      EXPECT_NEAR(sigma(0, 3 + i), m.mu() * (F(0, 3 * i + j) + F(0, 3 * j + i)), 1e-11);
    }
  }
}

TEST(ElasticBody, EnergyAlongAPathThatTurnsAnElementInsideOutIsTheWorkOnIt) {
  // Simpson's rule over short steps: a remaining difference would be a jump. The families climb to
  // 1000 E in a small part of the path, with a kink of the second derivative there
  Random random(10);
  for (const Element element : test::kAllElements)
    for (const Law law : test::kLaws) {
      const ElasticBody body(test::one_element(element, random), {test::solid(law)});
      const Eigen::VectorXd end = test::vector_of(test::inverted(body, random));
      const Eigen::VectorXd start = test::vector_of(
          test::displaced(body.mesh(), test::stretched(1.2, 1, 0.8, random), 0, random));
      const int steps = law.shape == 0 ? 2000 : 40000;
      double work = 0;
      for (int k = 0; k <= steps; ++k) {
        const double share = double(k) / steps;
        const Array<double> u = test::array_of((1 - share) * start + share * end);
        const double weight = k == 0 || k == steps ? 1 : k % 2 ? 4 : 2;
        work += weight / (3 * steps) * test::gradient(body, u).dot(end - start);
      }
      const double E = test::energy(body, test::array_of(end));
      const double bound = law.shape == 0 ? 1e-6 : 1e-5;
      EXPECT_NEAR(work, E - test::energy(body, test::array_of(start)), bound * E)
          << fem::element_name(element) << ' ' << law_name(law);
    }
}

TEST(ElasticBody, MeanDilatationChargesTheVolumeOfTheElementOnly) {
  // fixed corotated: lambda/2 (J - 1)^2 with J the ratio of the element's volumes
  Random random(11);
  for (const Element element : {Element::kHexBbar, Element::kTet10Bbar}) {
    const ElementMesh mesh = test::one_element(element, random);
    const Array<double> u =
        test::displaced(mesh, test::stretched(1.3, 1, 0.8, random), 0.05, random);
    ElementMesh moved = mesh;
    for (int64_t k = 0; k < u.size(); ++k) moved.rest.data()[k] += u.data()[k];
    const Material soft = test::solid(Law::kFixedCorotated, 1, 0),
                   stiff = test::solid(Law::kFixedCorotated, 1.49, 0.49);
    ASSERT_NEAR(soft.mu(), stiff.mu(), 1e-15);
    const double volume = ElasticBody(mesh, {soft}).volume()(0);
    const double J = ElasticBody(moved, {soft}).volume()(0) / volume;
    ASSERT_GE(std::abs(J - 1), 0.01);
    const double volumetric = volume * stiff.lambda() / 2 * (J - 1) * (J - 1);
    EXPECT_NEAR(test::energy({mesh, {stiff}}, u) - test::energy({mesh, {soft}}, u), volumetric,
                1e-12 * volumetric);
  }
}

TEST(ElasticBody, SameBitsOnAnyNumberOfThreads) {
  Random random(12);
  for (const Element element : test::kAllElements) {
    ElasticBody body(any_block(element, 6, 0.5), {test::solid()});
    const Array<double> u =
        test::displaced(body.mesh(), test::stretched(1.3, 1, 0.8, random), 0.03, random);
    const auto results = [&](int threads) {
      const ThreadLimit limit(threads);
      body.freeze_rotations(u);
      const EnergyParts parts = body.energy(u);
      Eigen::VectorXd all(2 + u.size());
      all << parts.elastic, parts.hourglass, test::gradient(body, u);
      return all;
    };
    const Eigen::VectorXd one = results(1);
    for (const int threads : {2, 7}) EXPECT_TRUE(results(threads) == one);
  }
}

}  // namespace
}  // namespace elastogen
