// SPDX-License-Identifier: Apache-2.0
// Gradient against energy and Hessian against gradient by Taylor's theorem: the remainder after
// the linear term falls with the square of the step.

#include "tests/mpm_fem/bodies.hpp"
#include "tests/support/eigenvalues.hpp"
#include "tests/support/laws.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace elastogen {
namespace {

using test::ElasticBody;
using test::Element;
using test::Random;

/// Smallest and largest slope of log remainder over log step, over the decades of the steps.
struct Slopes {
  double lowest = 10, highest = -10;
  void add(double larger, double smaller) {
    const double slope = std::log10(larger / smaller);
    lowest = std::min(lowest, slope), highest = std::max(highest, slope);
  }
};

constexpr double kSteps[3] = {1e-3, 1e-4, 1e-5};

/// Adds the slopes of the remainders of energy and gradient about u along a random direction.
/// @param unit  of the steps.
void add_slopes(const ElasticBody& body, const Array<double>& u, double unit, Random& random,
                Slopes& of_energy, Slopes& of_gradient) {
  std::normal_distribution<double> normal;
  const Eigen::VectorXd x = test::vector_of(u);
  const Eigen::VectorXd d = Eigen::VectorXd::NullaryExpr(x.size(), [&] { return normal(random); });
  const double E = test::energy(body, u);
  const Eigen::VectorXd g = test::gradient(body, u), Hd = test::hessian(body, u) * d;
  double energy[3], gradient[3];
  for (int k = 0; k < 3; ++k) {
    const double s = unit * kSteps[k];
    const Array<double> moved = test::array_of(x + s * d);
    energy[k] = std::abs(test::energy(body, moved) - E - s * g.dot(d));
    gradient[k] = (test::gradient(body, moved) - g - s * Hd).norm();
    if (k == 0) continue;
    of_energy.add(energy[k - 1], energy[k]);
    of_gradient.add(gradient[k - 1], gradient[k]);
  }
}

/// @param is_inverted  whether a quadrature point has det F < 0.
void expect_slopes(Element element, bool is_inverted) {
  Random random(1);
  Slopes of_energy, of_gradient;
  for (const Law law : test::kLaws)
    for (int sample = 0; sample < 5; ++sample) {
      ElasticBody body(test::one_element(element, random), {test::solid(law)});
      body.freeze_rotations(
          test::displaced(body.mesh(), test::stretched(1.2, 1, 0.8, random), 0.05, random));
      const Array<double> u =
          is_inverted
              ? test::inverted(body, random)
              : test::displaced(body.mesh(), test::stretched(1.4, 1, 0.7, random), 0.03, random);
      ASSERT_EQ(body.min_j(u) < 0, is_inverted);
      // the families are stiffer by orders where they are continued
      const double unit = is_inverted && law.shape != 0 ? 0.1 : 1;
      add_slopes(body, u, unit, random, of_energy, of_gradient);
    }
  printf("%-10s %-8s slopes: energy %.3f to %.3f, gradient %.3f to %.3f\n",
         std::string(fem::element_name(element)).c_str(), is_inverted ? "inverted" : "regular",
         of_energy.lowest, of_energy.highest, of_gradient.lowest, of_gradient.highest);
  EXPECT_GE(of_energy.lowest, 1.9);
  EXPECT_LE(of_energy.highest, 2.1);
  EXPECT_GE(of_gradient.lowest, 1.9);
  EXPECT_LE(of_gradient.highest, 2.1);
}

TEST(ElasticBody, GradientAndHessianAreTheDerivativesOfTheEnergyForEveryElementAndLaw) {
  for (const Element element : test::kAllElements) expect_slopes(element, false);
}

TEST(ElasticBody, TheyAreSoWhereAPointIsTurnedInsideOut) {
  for (const Element element : test::kAllElements) expect_slopes(element, true);
}

TEST(ElasticBody, HessiansAreSymmetricToTheBit) {
  Random random(2);
  for (const Element element : test::kAllElements) {
    const ElasticBody body(test::one_element(element, random), {test::solid()});
    const Array<double> u =
        test::displaced(body.mesh(), test::stretched(1.4, 1, 0.7, random), 0.05, random);
    for (const TangentKind kind : {TangentKind::kTrue, TangentKind::kProjected}) {
      const Eigen::MatrixXd K = test::element_hessian(body, 0, u, kind);
      EXPECT_TRUE(K == K.transpose()) << fem::element_name(element) << ' ' << int(kind);
    }
  }
}

TEST(ElasticBody, ProjectedHessianHasNoNegativeEigenvalue) {
  Random random(3);
  for (const Element element : test::kAllElements)
    for (const Law law : test::kLaws)
      for (int sample = 0; sample < 10; ++sample) {
        ElasticBody body(test::one_element(element, random), {test::solid(law)});
        const Array<double> u =
            sample % 2 ? test::inverted(body, random)
                       : test::displaced(body.mesh(), test::stretched_within(0.3, 1.5, random),
                                         0.05, random);
        body.freeze_rotations(u);
        const Eigen::MatrixXd K = test::element_hessian(body, 0, u, TangentKind::kProjected);
        EXPECT_GE(test::eigenvalues(K)(0), -1e-13 * K.norm())
            << fem::element_name(element) << ' ' << law_name(law);
      }
}

TEST(ElasticBody, ProjectedHessianIsTheExactOneWhereThatIsPositive) {
  Random random(4);
  for (const Element element : test::kAllElements)
    for (const Law law : test::kLaws) {
      const ElasticBody body(test::one_element(element, random), {test::solid(law)});
      const Array<double> u =
          test::displaced(body.mesh(), test::stretched(1.1, 1.08, 1.05, random), 0.001, random);
      const Eigen::MatrixXd exact = test::element_hessian(body, 0, u, TangentKind::kTrue);
      ASSERT_GE(test::eigenvalues(exact)(0), -1e-13 * exact.norm()) << fem::element_name(element);
      const Eigen::MatrixXd projected = test::element_hessian(body, 0, u, TangentKind::kProjected);
      EXPECT_LE((projected - exact).norm(), 1e-13 * exact.norm())
          << fem::element_name(element) << ' ' << law_name(law);
    }
}

TEST(ElasticBody, ProjectedHessianOfMeanDilatationIsTheClampedOne) {
  Random random(5);
  int changed = 0;
  for (const Element element : {Element::kHexBbar, Element::kTet10Bbar})
    for (const Law law : test::kLaws) {
      const ElasticBody body(test::one_element(element, random), {test::solid(law)});
      const Array<double> u =
          test::displaced(body.mesh(), test::stretched(1.2, 1, 0.6, random), 0.05, random);
      const Eigen::MatrixXd exact = test::element_hessian(body, 0, u, TangentKind::kTrue);
      const Eigen::MatrixXd projected = test::element_hessian(body, 0, u, TangentKind::kProjected);
      EXPECT_LE((projected - test::clamped(exact)).norm(), 1e-13 * exact.norm());
      changed += (projected - exact).norm() > 1e-3 * exact.norm();
    }
  EXPECT_GE(changed, 5);
}

}  // namespace
}  // namespace elastogen
