// SPDX-License-Identifier: Apache-2.0
// Damping of elements: derivatives, closed forms, what it must not feel.
#include "mpm_fem/fem/viscous_body.hpp"

#include "core/error.hpp"
#include "tests/mpm_fem/bodies.hpp"
#include "tests/support/eigenvalues.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace elastogen {
namespace {

using fem::ViscousBody;
using test::Element;
using test::ElementMesh;
using test::Random;

constexpr double kLoss = 0.3, kFrequency = 4, kRate = 50;
constexpr double kBeta = kLoss / (2 * std::numbers::pi * kFrequency) * kRate;

Material damped() {
  Material m = test::solid();
  m.loss_factor = kLoss;
  m.loss_frequency = kFrequency;
  return m;
}

/// A distorted element whose step begins with a strain.
struct Sample {
  ViscousBody body;
  Array<double> u;
};

Sample sample(Element element, Random& random, double noise = 0.05) {
  const ElementMesh mesh = test::one_element(element, random);
  Sample s{ViscousBody(mesh, {damped()}), {}};
  const Array<double> start =
      test::displaced(mesh, test::stretched(1.2, 1, 0.8, random), noise, random);
  s.body.begin(kRate, start, 0, {});
  s.u = test::displaced(mesh, test::stretched(1.4, 1, 0.7, random), noise, random);
  return s;
}

Eigen::VectorXd gradient(const ViscousBody& body, const Array<double>& u) {
  Array<double> g(u.rows(), 3);
  body.add_gradient(u, g);
  return test::vector_of(g);
}

Eigen::MatrixXd hessian(const ViscousBody& body, const Array<double>& u, TangentKind kind) {
  const int size = 3 * fem::nodes_of(body.mesh().element);
  Eigen::MatrixXd K(size, size);
  body.element_hessian(0, u, kind, K.data());
  return K;
}

TEST(ViscousBody, GradientAndHessianAreTheDerivatives) {
  Random random(1);
  std::normal_distribution<double> normal;
  for (const Element element : test::kAllElements)
    for (int k = 0; k < 4; ++k) {
      const Sample s = sample(element, random);
      const Eigen::VectorXd x = test::vector_of(s.u);
      const Eigen::VectorXd d =
          Eigen::VectorXd::NullaryExpr(x.size(), [&] { return normal(random); });
      const double e = 1e-6;
      const Array<double> high = test::array_of(x + e * d), low = test::array_of(x - e * d);
      const Eigen::VectorXd g = gradient(s.body, s.u),
                            Hd = hessian(s.body, s.u, TangentKind::kTrue) * d;
      ASSERT_GT(g.norm(), 0);
      EXPECT_NEAR((s.body.energy(high) - s.body.energy(low)) / (2 * e), g.dot(d),
                  1e-8 * g.norm() * d.norm())
          << fem::element_name(element);
      EXPECT_LT(((gradient(s.body, high) - gradient(s.body, low)) / (2 * e) - Hd).norm(),
                1e-8 * Hd.norm())
          << fem::element_name(element);
    }
}

TEST(ViscousBody, ProjectedHessianIsPositiveAndExactWhereAStepBeginsWithItsEnd) {
  Random random(2);
  for (const Element element : test::kAllElements)
    for (int k = 0; k < 10; ++k) {
      Sample s = sample(element, random);
      const Eigen::MatrixXd K = hessian(s.body, s.u, TangentKind::kProjected);
      EXPECT_TRUE(K == K.transpose()) << fem::element_name(element);
      EXPECT_GE(test::eigenvalues(K)(0), -1e-13 * K.norm()) << fem::element_name(element);
      s.body.begin(kRate, s.u, 0, {});
      const Eigen::MatrixXd exact = hessian(s.body, s.u, TangentKind::kTrue);
      EXPECT_LT((hessian(s.body, s.u, TangentKind::kProjected) - exact).norm(),
                1e-12 * exact.norm())
          << fem::element_name(element);
    }
}

TEST(ViscousBody, DoesNotFeelThatAnElementTurns) {
  Random random(3);
  for (const Element element : test::kAllElements) {
    Sample s = sample(element, random);
    s.body.begin(kRate, s.u, 0, {});
    const Mat3<double> R = test::rotation(random);
    Array<double> turned = s.u;
    const Array<double>& X = s.body.mesh().rest;
    for (int64_t n = 0; n < turned.rows(); ++n)
      for (int i = 0; i < 3; ++i) {
        turned(n, i) = 0.3 - X(n, i);
        for (int j = 0; j < 3; ++j) turned(n, i) += R(i, j) * (X(n, j) + s.u(n, j));
      }
    EXPECT_LT(s.body.energy(turned), 1e-28) << fem::element_name(element);
    EXPECT_LT(gradient(s.body, turned).norm(), 1e-14) << fem::element_name(element);
  }
}

TEST(ViscousBody, OfAHomogeneousStretchIsThatOfTheFormula) {
  // from a stretch a to a stretch b along x; E = (s^2 - 1)/2, of the other strains none changes
  Random random(4);
  const double a = 1.1, b = 1.3, strain = (b * b - a * a) / 2;
  const Material m = damped();
  for (const Element element : test::kAllElements) {
    const ElementMesh mesh = test::one_element(element, random);
    ViscousBody body(mesh, {m});
    const fem::ElasticBody elastic(mesh, {m});
    const auto stretch = [&](double s) {
      Mat3<double> F = identity<double>();
      F(0, 0) = s;
      return test::displaced(mesh, F, 0, random);
    };
    body.begin(kRate, stretch(a), 0, {});
    const double expected =
        elastic.volume()(0) * kBeta * (m.mu() + m.lambda() / 2) * strain * strain;
    EXPECT_NEAR(body.energy(stretch(b)), expected, 1e-12 * expected) << fem::element_name(element);
    // E_b between two strains: (1 - w) E(a) + w E(b) leaves the share 1 - w, and of the rate half
    body.begin(kRate, stretch(a), 0.25, stretch(b));
    body.set_rate(kRate / 2);
    EXPECT_NEAR(body.energy(stretch(b)), expected * 0.75 * 0.75 / 2, 1e-12 * expected);
  }
}

TEST(ViscousBody, OfABentVoxelIsTheVarianceOfItsStrain) {
  // u_x = k y z in a full voxel: F at the centre stays I, and q_yz of x alone is 8 k h^2/4
  const double k = 0.1, h = 0.5;
  Scene scene = test::voxel_scene(make_box(1, 1, 1, h), damped());
  const ElementMesh mesh = fem::voxel_mesh(scene, Element::kVoxel);
  ViscousBody body(mesh, {damped()});
  Array<double> u(8, 3);
  body.begin(kRate, u, 0, {});
  for (int64_t n = 0; n < 8; ++n)
    u(n, 0) = k * (mesh.rest(n, 1) - h / 2) * (mesh.rest(n, 2) - h / 2);
  const double q = 2 * k * h * h, expected = kBeta * h / 2 * mesh.variance(0, 1) * q * q / 24;
  EXPECT_NEAR(body.energy(u), expected, 1e-12 * expected);
  // none of it without the variance term
  scene.hourglass = Hourglass::kOff;
  ViscousBody off(fem::voxel_mesh(scene, Element::kVoxel), {damped()});
  off.begin(kRate, Array<double>(8, 3), 0, {});
  EXPECT_EQ(off.energy(u), 0);
}

TEST(ViscousBody, OnlyDampedMaterialsTakePart) {
  ElementMesh mesh = test::block(Element::kHex, 2, 1, 1, 1);
  mesh.material(1) = 1;
  ViscousBody both(mesh, {damped(), test::solid()});
  ViscousBody one(test::first_element(mesh), {damped()});
  Array<double> u(mesh.rest.rows(), 3), part(8, 3);
  both.begin(kRate, u, 0, {});
  one.begin(kRate, part, 0, {});
  for (int64_t n = 0; n < u.rows(); ++n) u(n, 0) = 0.1 * mesh.rest(n, 0);
  for (int64_t n = 0; n < 8; ++n) part(n, 0) = 0.1 * one.mesh().rest(n, 0);
  EXPECT_GT(one.energy(part), 0);
  EXPECT_NEAR(both.energy(u), one.energy(part), 1e-14 * one.energy(part));
  EXPECT_EQ(hessian(one, part, TangentKind::kTrue).rows(), 24);
  mesh.material(1) = 2;
  EXPECT_THROW(ViscousBody(mesh, {damped(), test::solid()}), Error);
}

}  // namespace
}  // namespace elastogen
