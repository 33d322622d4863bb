// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/fem/plastic_body.hpp"

#include "core/error.hpp"
#include "mpm_fem/fem/inversion_bound.hpp"
#include "mpm_fem/fem/mesh_part.hpp"
#include "tests/mpm_fem/bodies.hpp"
#include "tests/mpm_fem/return_maps.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace elastogen {
namespace {

using fem::PlasticBody;
using fem::PlasticHistory;
using test::Element;
using test::Random;

constexpr Element kElements[] = {Element::kHex, Element::kHexBbar, Element::kTet4, Element::kTet10,
                                 Element::kTet10Bbar};

Solid solid_of(const Yield& yield, Law law = Law::kHencky) {
  Solid solid{test::plastic_solid(), yield};
  solid.elastic.law = law;
  return solid;
}
std::vector<Solid> metals() {
  return {solid_of(test::kMetal), solid_of(test::kMetal, Law::kNeoHookean)};
}
std::vector<Solid> grains() {
  return {solid_of(test::kSand), solid_of(test::kSnow)};
}

/// A displacement with strains of about `size`.
Array<double> strained(const fem::ElementMesh& mesh, double size, Random& random) {
  std::normal_distribution<double> normal(0, size);
  Array<double> u(mesh.rest.rows(), 3);
  for (int64_t k = 0; k < u.size(); ++k) u.data()[k] = normal(random);
  return u;
}

/// A body that has flowed once.
PlasticBody flowed(Element element, const Solid& solid, Random& random) {
  const fem::ElementMesh mesh = test::block(element, 1, 1, 2, 1, 0.1);
  PlasticBody body(mesh, {solid});
  body.set_history(body.history_after(strained(mesh, 0.05, random)));
  return body;
}

Eigen::VectorXd force(const PlasticBody& body, const Array<double>& u) {
  Array<double> g(u.rows(), 3);
  body.add_gradient(u, g);
  return test::vector_of(g);
}

Eigen::VectorXd stiffness_times(const PlasticBody& body, const Array<double>& u,
                                const Eigen::VectorXd& d) {
  const Array<int32_t>& elements = body.mesh().elements;
  Eigen::VectorXd result = Eigen::VectorXd::Zero(d.size());
  const int n = elements.cols();
  Eigen::Matrix<double, -1, -1, Eigen::RowMajor> K(3 * n, 3 * n);
  for (int64_t e = 0; e < elements.rows(); ++e) {
    body.element_hessian(e, u, TangentKind::kTrue, K.data());
    for (int row = 0; row < 3 * n; ++row)
      for (int col = 0; col < 3 * n; ++col)
        result(3 * elements(e, row / 3) + row % 3) +=
            K(row, col) * d(3 * elements(e, col / 3) + col % 3);
  }
  return result;
}

/// Central differences along d about u.
struct Differences {
  double energy;
  Eigen::VectorXd force;
};
Differences differences(const PlasticBody& body, const Array<double>& u, const Eigen::VectorXd& d) {
  constexpr double kStep = 1e-6;
  const Eigen::VectorXd x = test::vector_of(u);
  const Array<double> ahead = test::array_of(x + kStep * d), back = test::array_of(x - kStep * d);
  return {(body.energy(ahead) - body.energy(back)) / (2 * kStep),
          (force(body, ahead) - force(body, back)) / (2 * kStep)};
}

/// Whether forces and, with a potential, energy have the derivatives about u that differences show.
bool has_derivatives(const PlasticBody& body, const Array<double>& u, bool has_energy,
                     Random& random) {
  std::normal_distribution<double> normal;
  const Eigen::VectorXd d = Eigen::VectorXd::NullaryExpr(u.size(), [&] { return normal(random); });
  const Differences found = differences(body, u, d);
  const Eigen::VectorXd Kd = stiffness_times(body, u, d), f = force(body, u);
  const bool force_fits = (found.force - Kd).norm() < 1e-6 * Kd.norm();
  const bool energy_fits = std::abs(found.energy - f.dot(d)) < 1e-7 * f.norm() * d.norm();
  return force_fits && (energy_fits || !has_energy);
}

TEST(PlasticBody, ForceAndStiffnessAreTheDerivatives) {
  // one of the samples may have a point whose branch ends within the difference
  constexpr int kSamples = 6, kEnough = 5;
  Random random(3);
  for (const Element element : kElements) {
    for (const Solid& solid : metals()) {
      int good = 0;
      for (int sample = 0; sample < kSamples; ++sample) {
        const PlasticBody body = flowed(element, solid, random);
        good += has_derivatives(body, strained(body.mesh(), 0.05, random), true, random);
      }
      EXPECT_GE(good, kEnough) << fem::element_name(element);
    }
    for (const Solid& solid : grains()) {
      int good = 0, frozen = 0;
      for (int sample = 0; sample < kSamples; ++sample) {
        PlasticBody body = flowed(element, solid, random);
        const Array<double> u = strained(body.mesh(), 0.03, random);
        good += has_derivatives(body, u, false, random);
        body.freeze(strained(body.mesh(), 0.03, random));
        frozen += has_derivatives(body, u, true, random);
      }
      EXPECT_GE(good, kEnough) << fem::element_name(element);
      EXPECT_GE(frozen, kEnough) << fem::element_name(element);
    }
  }
}

TEST(PlasticBody, FrozenPotentialsHaveTheTrueForcesWhereTheyAreFrozen) {
  Random random(4);
  for (const Element element : kElements)
    for (const Solid& solid : grains()) {
      PlasticBody body = flowed(element, solid, random);
      const Array<double> u = strained(body.mesh(), 0.05, random);
      const Eigen::VectorXd f = force(body, u);
      body.freeze(u);
      EXPECT_NEAR((force(body, u) - f).norm(), 0, 1e-12 * f.norm());
    }
}

TEST(PlasticBody, StressAfterTheStepIsThatAtItsEnd) {
  Random random(5);
  for (const Element element : kElements)
    for (const Solid& solid : {metals()[0], metals()[1], grains()[0]}) {
      PlasticBody body = flowed(element, solid, random);
      const Array<double> u = strained(body.mesh(), 0.05, random);
      const Eigen::VectorXd f = force(body, u);
      const PlasticHistory after = body.history_after(u);
      const double elastic = body.work(u).elastic;
      body.set_history(after);
      EXPECT_NEAR((force(body, u) - f).norm(), 0, 1e-10 * f.norm());
      EXPECT_NEAR(body.work(u).elastic, elastic, 1e-10 * elastic);
      EXPECT_NEAR(body.work(u).plastic, 0, 1e-10 * elastic);
    }
}

TEST(PlasticBody, MetalKeepsTheVolumeInItsFlow) {
  Random random(6);
  for (const Solid& solid : metals()) {
    const PlasticBody body = flowed(Element::kHexBbar, solid, random);
    const PlasticHistory after = body.history_after(strained(body.mesh(), 0.1, random));
    for (int64_t k = 0; k < after.memory.rows(); ++k) {
      Mat3<double> Fp_inverse;
      std::copy_n(after.Fp_inverse.row(k), 9, Fp_inverse.m);
      EXPECT_NEAR(determinant(Fp_inverse), 1, 1e-13);
      EXPECT_GT(after.memory(k), 0);
    }
  }
}

TEST(PlasticBody, TurnsWithItsRotation) {
  Random random(7);
  const Eigen::Matrix3d R =
      Eigen::AngleAxisd(1.2, Eigen::Vector3d(1, 2, -0.5).normalized()).toRotationMatrix();
  for (const Element element : kElements)
    for (const Solid& solid : {metals()[0], metals()[1], grains()[0], grains()[1]}) {
      const PlasticBody body = flowed(element, solid, random);
      const Array<double> u = strained(body.mesh(), 0.05, random);
      Array<double> turned(u.rows(), 3);
      for (int64_t n = 0; n < u.rows(); ++n) {
        const Eigen::Vector3d X(body.mesh().rest.row(n)), moved(u.row(n));
        Eigen::Map<Eigen::Vector3d>(turned.row(n)) = R * (X + moved) - X;
      }
      const Eigen::VectorXd f = force(body, u), g = force(body, turned);
      for (int64_t n = 0; n < u.rows(); ++n)
        EXPECT_NEAR((g.segment<3>(3 * n) - R * f.segment<3>(3 * n)).norm(), 0, 1e-11 * f.norm());
      EXPECT_NEAR(body.work(turned).plastic, body.work(u).plastic, 1e-11 * body.work(u).elastic);
    }
}

TEST(PlasticBody, FlowDissipates) {
  Random random(8);
  for (const Solid& solid : {metals()[0], metals()[1], grains()[0], grains()[1]}) {
    double sum = 0;
    for (int sample = 0; sample < 20; ++sample) {
      const PlasticBody body = flowed(Element::kHexBbar, solid, random);
      const StepWork work = body.work(strained(body.mesh(), 0.05, random));
      EXPECT_GE(work.plastic, -1e-13 * work.elastic);
      sum += work.plastic;
    }
    EXPECT_GT(sum, 0);
  }
}

TEST(PlasticBody, IsElasticBelowYield) {
  Random random(9);
  const fem::ElementMesh mesh = test::block(Element::kHex, 2, 1, 1, 1, 0.1);
  Solid strong = solid_of(MetalYield{.stress = 10});
  const PlasticBody body(mesh, {strong});
  const test::ElasticBody elastic(mesh, {strong.elastic});
  const Array<double> u = strained(mesh, 0.05, random);
  EXPECT_NEAR(body.energy(u), elastic.energy(u).elastic, 1e-13 * body.energy(u));
  EXPECT_NEAR((force(body, u) - test::gradient(elastic, u)).norm(), 0, 1e-12);
  EXPECT_EQ(body.work(u).plastic, 0);
  const PlasticHistory after = body.history_after(u), rest = body.rest_history();
  EXPECT_TRUE(std::equal(after.Fp_inverse.data(), after.Fp_inverse.data() + after.Fp_inverse.size(),
                         rest.Fp_inverse.data()));
}

TEST(PlasticBody, StepsStopBeforeAPointTurnsInsideOut) {
  const fem::ElementMesh mesh = test::block(Element::kHex, 1, 1, 1, 1);
  const PlasticBody body(mesh, {metals()[0]});
  Array<double> u(mesh.rest.rows(), 3), end = u;
  for (int64_t n = 0; n < u.rows(); ++n) end(n, 0) = -2 * mesh.rest(n, 0);
  // det F = 1 - 2 a, a tenth at a = 0.45
  EXPECT_NEAR(body.longest_step(u, end), 0.9 * 0.45, 1e-8);
  for (int64_t n = 0; n < u.rows(); ++n) end(n, 0) = mesh.rest(n, 0);
  EXPECT_EQ(body.longest_step(u, end), 1);
}

TEST(InversionBound, IsTheFirstPlaceOfACubic) {
  Random random(10);
  std::uniform_real_distribution<double> in(-2, 2);
  for (int sample = 0; sample < 200; ++sample) {
    Mat3<double> F = identity<double>(), end;
    for (double& x : end.m) x = in(random);
    const double share = fem::share_before_inversion(F, end);
    double first = 1;
    for (int k = 1; k <= 2000 && first == 1; ++k) {
      Mat3<double> at;
      for (int i = 0; i < 9; ++i) at.m[i] = F.m[i] + k / 2000.0 * (end.m[i] - F.m[i]);
      if (determinant(at) < 0.1) first = k / 2000.0;
    }
    if (first < 1)
      EXPECT_NEAR(share, 0.9 * first, 6e-4);
    else
      EXPECT_GE(share, 0.9);
  }
}

TEST(MeshPart, HasTheElementsOfItsMaterials) {
  fem::ElementMesh mesh = test::block(Element::kHex, 3, 1, 1, 1);
  mesh.material(1) = 1;
  const fem::ElementMesh part = fem::part_of(mesh, {true, false});
  ASSERT_EQ(part.elements.rows(), 2);
  EXPECT_EQ(part.elements(1, 0), mesh.elements(2, 0));
  EXPECT_EQ(part.rest.rows(), mesh.rest.rows());
  EXPECT_EQ(fem::part_of(mesh, {false, false}).elements.rows(), 0);
}

TEST(PlasticBody, RejectsWhatItsDocumentationForbids) {
  fem::ElementMesh mesh = test::block(Element::kHex, 1, 1, 1, 1);
  PlasticBody body(mesh, metals());
  EXPECT_THROW(body.set_history({Array<double>(7, 9), Array<double>(8)}), Error);
  EXPECT_THROW(body.energy(Array<double>(3, 3)), Error);
  mesh.material(0) = 2;
  EXPECT_THROW(PlasticBody(mesh, metals()), Error);
  Random random(1);
  EXPECT_THROW(PlasticBody(test::one_voxel(random, Hourglass::kFull), metals()), Error);
}

}  // namespace
}  // namespace elastogen
