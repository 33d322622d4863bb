// SPDX-License-Identifier: Apache-2.0
// Terms over one vector of unknowns: two meshes, a spring between them that comes and goes.

#include "mpm_fem/solve/potential.hpp"

#include "core/error.hpp"
#include "core/reduce.hpp"
#include "mpm_fem/integrators/static_fem.hpp"
#include "mpm_fem/solve/elastic_term.hpp"
#include "tests/mpm_fem/scenes.hpp"
#include "tests/mpm_fem/spring.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>

namespace elastogen::test {
namespace {

using fem::ElasticTerm;
using fem::MassMatrix;
using fem::NewtonStop;
using fem::Potential;

Array<double> masses(const std::vector<double>& values) {
  Array<double> mass(int64_t(values.size()));
  std::copy(values.begin(), values.end(), mass.data());
  return mass;
}

TEST(Potential, PatternFollowsASpringThatAttachesAndLetsTheAnalysisBe) {
  constexpr double kWeight = 50, kSpring = 30, kMass[2] = {0.5, 2};
  Array<double> rest(3, 3), ahead(3, 3), u(3, 3);
  rest(1, 0) = 1, rest(2, 1) = 5;
  ahead(0, 1) = 0.1, ahead(1, 0) = 0.4, ahead(2, 2) = -1;
  Spring spring(rest, 0, 1, kSpring);
  Potential potential(rest, {}, MassMatrix(masses({kMass[0], kMass[1], 1})), {&spring});
  potential.set_inertia(kWeight, ahead);
  EXPECT_EQ(potential.hessian().entries(), 3 * 9);

  // free: to the predictor
  EXPECT_EQ(potential.minimise({.tolerance = 1e-12}, u.data()).stop, NewtonStop::kConverged);
  for (int64_t k = 0; k < 9; ++k) EXPECT_NEAR(u.data()[k], ahead.data()[k], 1e-14);
  EXPECT_EQ(potential.solver().analyses(), 1);

  // attached: the stretch shrinks by the compliance of both masses, about their centre
  spring.attach();
  for (int repeat = 0; repeat < 2; ++repeat) {
    EXPECT_EQ(potential.minimise({.tolerance = 1e-12}, u.data()).stop, NewtonStop::kConverged);
    EXPECT_EQ(potential.solver().analyses(), 2);
    EXPECT_EQ(potential.hessian().entries(), 3 * 9 + 2 * 9);
    const double share = 1 / (1 + kSpring / kWeight * (1 / kMass[0] + 1 / kMass[1]));
    const double stretch[3] = {1.4, -0.1, 0};
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(rest(1, i) + u(1, i) - rest(0, i) - u(0, i), share * stretch[i], 1e-14);
      EXPECT_NEAR(kMass[0] * (u(0, i) - ahead(0, i)) + kMass[1] * (u(1, i) - ahead(1, i)), 0,
                  1e-14);
      EXPECT_NEAR(u(2, i), ahead(2, i), 1e-14);
    }
    // from elsewhere the second time
    u.fill(0.3);
  }
}

/// Two bars in a row along x with a gap, in one numbering; a spring from the end of the first to
/// the start of the second.
struct TwoBars {
  static constexpr double kEdge = 0.1, kGap = 1e-6, kSpring = 2e3;
  FemScene first, second;
  Array<double> rest;
  Array<uint8_t> fixed;
  int32_t end = -1, start = -1;  // nodes of the spring

  TwoBars(Element element, bool clamped) {
    first = box_of(element, 4, 1, 1, kEdge, solid(Law::kNeoHookean, 1e5));
    second = box_of(element, 3, 1, 1, kEdge, solid(Law::kStvk, 3e5));
    for (int64_t n = 0; n < second.mesh.rest.rows(); ++n)
      second.mesh.rest(n, 0) += 4 * kEdge + kGap;
    if (clamped) clamp(first, 0, 0), clamp(second, 0, 7 * kEdge + kGap);
    const int64_t of_first = first.mesh.rest.rows();
    rest = Array<double>(of_first + second.mesh.rest.rows(), 3);
    fixed = Array<uint8_t>(rest.rows(), 3);
    int64_t k = 0;
    for (const FemScene* scene : {&first, &second})
      for (int64_t l = 0; l < scene->mesh.rest.size(); ++l, ++k) {
        rest.data()[k] = scene->mesh.rest.data()[l];
        fixed.data()[k] = scene->fixed.data()[l];
      }
    end = int32_t(plane(first.mesh, 0, 4 * kEdge)[0]);
    start = int32_t(of_first + plane(second.mesh, 0, 4 * kEdge + kGap)[0]);
  }

  Array<double> mass() const {
    Array<double> result(rest.rows());
    int64_t k = 0;
    for (const FemScene* scene : {&first, &second}) {
      const Array<double> own = ElasticBody(scene->mesh, scene->materials).lumped_mass();
      for (int64_t n = 0; n < own.rows(); ++n, ++k) result(k) = own(n);
    }
    return result;
  }
};

/// The bars with their spring attached, as one potential.
struct JoinedBars {
  TwoBars bars;
  ElasticTerm first, second;
  Spring spring;
  Potential potential;

  JoinedBars(Element element, bool clamped)
      : bars(element, clamped),
        first(bars.first.mesh, bars.first.materials),
        second(bars.second.mesh, bars.second.materials, int32_t(bars.first.mesh.rest.rows())),
        spring(bars.rest, bars.end, bars.start, TwoBars::kSpring),
        potential(bars.rest, bars.fixed, MassMatrix(bars.mass()), {&first, &second, &spring}) {
    spring.attach();
  }
};

/// Displacement of a node of a body under small forces on it, by a static solution of its own.
Eigen::Matrix3d compliance(FemScene scene, int64_t node) {
  constexpr double kForce = 1e-4;
  Eigen::Matrix3d C;
  for (int i = 0; i < 3; ++i) {
    scene.traction = Array<double>(scene.mesh.rest.rows(), 3);
    scene.traction(node, i) = kForce;
    const fem::StaticResult result = solve_static(scene, {.tolerance = 1e-9});
    EXPECT_TRUE(result.converged);
    for (int j = 0; j < 3; ++j) C(j, i) = result.u(node, j) / kForce;
  }
  return C;
}

TEST(Potential, TwoBodiesJoinedByASpringGiveWayByTheirCompliances) {
  for (const Element element : {Element::kHex, Element::kTet4}) {
    JoinedBars joined(element, true);
    const TwoBars& bars = joined.bars;
    Potential& potential = joined.potential;
    const auto nodes = int32_t(bars.first.mesh.rest.rows());
    Array<double> u(bars.rest.rows(), 3);
    EXPECT_EQ(potential.minimise({.tolerance = 1e-9}, u.data()).stop, NewtonStop::kConverged);

    const Eigen::Matrix3d C = compliance(bars.first, bars.end),
                          D = compliance(bars.second, bars.start - nodes);
    const Eigen::Vector3d gap(TwoBars::kGap, 0, 0);
    const Eigen::Vector3d force =
        (Eigen::Matrix3d::Identity() + TwoBars::kSpring * (C + D)).inverse() *
        (TwoBars::kSpring * gap);
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(u(bars.end, i), (C * force)(i), 1e-4 * (C * force).norm());
      EXPECT_NEAR(u(bars.start, i), -(D * force)(i), 1e-4 * (D * force).norm());
    }
    EXPECT_GT((C * force).norm(), 0.1 * TwoBars::kGap);
  }
}

TEST(Potential, AFreePairKeepsItsMomenta) {
  JoinedBars joined(Element::kHex, false);
  const TwoBars& bars = joined.bars;
  Potential& potential = joined.potential;
  Random random(8);
  std::normal_distribution<double> normal(0, 0.02);
  Array<double> ahead(bars.rest.rows(), 3), u = ahead;
  for (int64_t k = 0; k < ahead.size(); ++k) ahead.data()[k] = normal(random);
  constexpr double kWeight = 1e4;
  potential.set_inertia(kWeight, ahead);
  EXPECT_EQ(potential.minimise({.tolerance = 1e-9}, u.data()).stop, NewtonStop::kConverged);

  // the inertial forces on both bodies have no resultant and no moment
  const Array<double>& m = potential.mass().nodal();
  Vec3 force = {}, moment = {};
  double size = 0;
  for (int64_t n = 0; n < u.rows(); ++n) {
    double f[3], x[3];
    for (int i = 0; i < 3; ++i) {
      f[i] = kWeight * m(n) * (u(n, i) - ahead(n, i));
      x[i] = bars.rest(n, i) + u(n, i);
      force[size_t(i)] += f[i];
      size += std::abs(f[i]);
    }
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      moment[size_t(i)] += x[j] * f[k] - x[k] * f[j];
    }
  }
  EXPECT_GT(size, 1);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(force[i], 0, 1e-8);
    EXPECT_NEAR(moment[i], 0, 1e-8);
  }
}

TEST(Potential, GradientIsTheSlopeOfTheSumOfItsTerms) {
  JoinedBars joined(Element::kHex, false);
  const TwoBars& bars = joined.bars;
  Potential& potential = joined.potential;
  Random random(9);
  std::normal_distribution<double> normal(0, 0.01);
  Array<double> u(bars.rest.rows(), 3), ahead = u, force = u, along = u, g = u, unused = u;
  for (Array<double>* array : {&u, &ahead, &force, &along})
    for (int64_t k = 0; k < u.size(); ++k) array->data()[k] = normal(random);
  potential.set_inertia(1e3, ahead);
  potential.set_force(force);
  potential.evaluate(u.data(), g.data());
  constexpr double kStep = 1e-4;
  Array<double> above = u, below = u;
  add_scaled(kStep, along.data(), above.data(), u.size());
  add_scaled(-kStep, along.data(), below.data(), u.size());
  const double slope = (potential.evaluate(above.data(), unused.data()).value -
                        potential.evaluate(below.data(), unused.data()).value) /
                       (2 * kStep);
  EXPECT_NEAR(dot(g.data(), along.data(), u.size()), slope, 1e-6 * std::abs(slope));
}

TEST(Potential, RejectsWhatItsDocumentationForbids) {
  Array<double> rest(2, 3);
  const MassMatrix mass(masses({1, 1}));
  Spring away(rest, 0, 2, 1);
  EXPECT_THROW(Potential(rest, Array<uint8_t>(2, 2), mass, {}), Error);
  EXPECT_THROW(Potential(rest, {}, MassMatrix(masses({1})), {}), Error);
  EXPECT_THROW(Potential(Array<double>(2, 2), {}, mass, {}), Error);
  EXPECT_THROW(MassMatrix(masses({1, 0})), Error);
  EXPECT_THROW(MassMatrix(Array<double>(1, 2)), Error);
  away.attach();
  EXPECT_THROW(Potential(rest, {}, mass, {&away}), Error);

  // a term that adds where its stencils are not
  Spring spring(rest, 0, 1, 1);
  spring.attach();
  fem::SparseMatrix H = fem::pattern_of({}, 2);
  EXPECT_THROW(spring.add_hessian(rest, TangentKind::kTrue, H), Error);
}

TEST(Potential, TakesNoNodesAndNoTerms) {
  Potential potential(Array<double>(0, 3), {}, MassMatrix(masses({})), {});
  double none = 0;
  EXPECT_EQ(potential.minimise({.tolerance = 0}, &none).stop, NewtonStop::kConverged);
  Array<double> rest(1, 3), ahead(1, 3), u(1, 3);
  ahead.fill(2);
  Potential point(rest, {}, MassMatrix(masses({3})), {});
  point.set_inertia(1, ahead);
  EXPECT_EQ(point.minimise({.tolerance = 1e-14}, u.data()).stop, NewtonStop::kConverged);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(u(0, i), 2, 1e-14);
}

}  // namespace
}  // namespace elastogen::test
