// SPDX-License-Identifier: Apache-2.0
// Tetrahedra that borders cut: integrals over the free part, and nodes that follow others.
#include "mpm_fem/fem/cut_tets.hpp"

#include "core/vec3.hpp"
#include "mpm_fem/fem/dependent_tet_nodes.hpp"
#include "tests/mpm_fem/bodies.hpp"
#include "tests/network/held_scenes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace elastogen::test {
namespace {

constexpr double kDensity = 1000;

/// rho times the integrals of p q over the elements, of fields p and q that the nodes give.
double weighed(const ElementMesh& mesh, const std::function<double(const Vec3&)>& p,
               const std::function<double(const Vec3&)>& q) {
  const ElasticBody body(mesh, {solid()});
  const int nodes = fem::nodes_of(mesh.element);
  double sum = 0;
  for (int64_t e = 0; e < mesh.elements.rows(); ++e) {
    double M[100];
    body.element_mass(e, M);
    for (int a = 0; a < nodes; ++a)
      for (int b = 0; b < nodes; ++b)
        sum += M[nodes * a + b] * p(rest_of(mesh, mesh.elements(e, a))) *
               q(rest_of(mesh, mesh.elements(e, b)));
  }
  return sum;
}

double unit_field(const Vec3&) {
  return 1;
}

TEST(CutTets, HaveTheIntegralsOfWhatPlanesLeave) {
  // a block of 0.9 x 0.6 x 0.6 less x < 0.217 and y > 0.43
  const std::vector<Border> borders = {half_space_border(true, 0.217),
                                       half_space_border(false, 0.43, 1)};
  const double lower[3] = {0.217, 0, 0}, upper[3] = {0.9, 0.43, 0.6};
  const auto moment = [&](int d, int power) {
    return (std::pow(upper[d], power + 1) - std::pow(lower[d], power + 1)) / (power + 1);
  };
  for (const Element element : {Element::kTet4, Element::kTet10}) {
    const auto cut = fem::cut_tets(block(element, 3, 2, 2, 0.3), borders);
    EXPECT_FALSE(cut.cut.empty());
    const double V = moment(0, 0) * moment(1, 0) * moment(2, 0) * kDensity;
    EXPECT_NEAR(weighed(cut.mesh, unit_field, unit_field), V, 1e-12 * V);
    for (int d = 0; d < 3; ++d) {
      const auto x = [&](const Vec3& X) { return X[size_t(d)]; };
      EXPECT_NEAR(weighed(cut.mesh, x, unit_field), V * moment(d, 1) / moment(d, 0), 1e-12 * V);
      EXPECT_NEAR(weighed(cut.mesh, x, x), V * moment(d, 2) / moment(d, 0), 1e-12 * V);
    }
    const auto x = [](const Vec3& X) { return X[0]; };
    const auto y = [](const Vec3& X) { return X[1]; };
    EXPECT_NEAR(weighed(cut.mesh, x, y),
                V * moment(0, 1) / moment(0, 0) * moment(1, 1) / moment(1, 0), 1e-12 * V);
    double volume = 0;
    const Array<double> volumes = ElasticBody(cut.mesh, {solid()}).volume();
    for (int64_t e = 0; e < volumes.rows(); ++e) volume += volumes(e) * kDensity;
    EXPECT_NEAR(volume, V, 1e-12 * V);
  }
}

TEST(CutTets, OfQuadraticElementsHaveTheEnergyOfAQuadraticField) {
  // St. Venant: of u = (c x^2, 0, 0), F_11 = 1 + 2 c x, to second order in c the energy density is
  // (lambda + 2 mu)/2 (2 c x)^2
  const double c = 1e-5, place = 0.217;
  const auto cut =
      fem::cut_tets(block(Element::kTet10, 2, 1, 1, 0.3), {half_space_border(true, place)});
  const Material material = solid(Law::kStvk);
  Array<double> u(cut.mesh.rest.rows(), 3);
  for (int64_t n = 0; n < u.rows(); ++n) u(n, 0) = c * cut.mesh.rest(n, 0) * cut.mesh.rest(n, 0);
  const double energy = ElasticBody(cut.mesh, {material}).energy(u).elastic;
  const double expected = (material.lambda() + 2 * material.mu()) / 2 * 4 * c * c *
                          (std::pow(0.6, 3) - std::pow(place, 3)) / 3 * 0.3 * 0.3;
  EXPECT_NEAR(energy, expected, 1e-4 * expected);
}

TEST(CutTets, AreTheirOwnWhereBordersFit) {
  const ElementMesh mesh = block(Element::kTet4, 3, 2, 2, 0.3);
  for (const double place : {0.3, -0.1, 0.9}) {
    const Border border = half_space_border(true, place);
    EXPECT_FALSE(fem::cuts(mesh, border)) << place;
  }
  EXPECT_TRUE(fem::cuts(mesh, half_space_border(true, 1e-4)));
  const auto cut = fem::cut_tets(mesh, {});
  EXPECT_EQ(cut.mesh.elements, mesh.elements);
  EXPECT_TRUE(cut.mesh.part.empty());
}

TEST(CutTets, LeaveWhatBallsAndBoxesLeave) {
  const ElementMesh mesh = block(Element::kTet4, 4, 4, 4, 0.15);
  const Vec3 centre = {0.31, 0.28, 0.3};
  const double ball = 4.0 / 3 * std::numbers::pi * std::pow(0.2, 3);
  const auto free = fem::cut_tets(mesh, {ball_border(centre, 0.2)});
  EXPECT_NEAR(weighed(free.mesh, unit_field, unit_field) / kDensity, 0.216 - ball, 0.01 * ball);
  Border box;
  box.lower = {0.11, 0.12, 0.13};
  box.upper = {0.41, 0.38, 0.5};
  const auto around = fem::cut_tets(mesh, {box});
  const double held = 0.3 * 0.26 * 0.37;
  EXPECT_NEAR(weighed(around.mesh, unit_field, unit_field) / kDensity, 0.216 - held, 0.02 * held);
}

/// Dependent nodes of a mesh that borders cut, of which none is pinned.
DependentNodes followers(const ElementMesh& mesh, const std::vector<Border>& borders) {
  const auto cut = fem::cut_tets(mesh, borders);
  return fem::dependent_tet_nodes(cut.mesh, borders, cut.cut, Array<uint8_t>(mesh.rest.rows()));
}

TEST(DependentTetNodes, MeetFieldsThatAreLinearAndZeroOnTheBorder) {
  for (const Element element : {Element::kTet4, Element::kTet10})
    for (const double place : {0.217, 0.301, 0.299, 0.59}) {
      const ElementMesh mesh = block(element, 3, 2, 2, 0.3);
      const DependentNodes dependent = followers(mesh, {half_space_border(true, place)});
      ASSERT_FALSE(dependent.empty());
      std::vector<double> u(size_t(3 * mesh.rest.rows()));
      for (int64_t n = 0; n < mesh.rest.rows(); ++n)
        for (int d = 0; d < 3; ++d) u[size_t(3 * n + d)] = (0.3 + d) * (mesh.rest(n, 0) - place);
      std::vector<double> filled = u;
      dependent.fill(filled.data());
      for (size_t k = 0; k < u.size(); ++k) EXPECT_NEAR(filled[k], u[k], 1e-13);
    }
}

TEST(DependentTetNodes, CarryLinearSlopesAlongTheNormal) {
  // nodes inside of the block: slopes that are linear along the border
  const ElementMesh mesh = block(Element::kTet4, 3, 4, 4, 0.3);
  const double place = 0.36;
  const DependentNodes dependent = followers(mesh, {half_space_border(true, place)});
  std::vector<double> u(size_t(3 * mesh.rest.rows()));
  for (int64_t n = 0; n < mesh.rest.rows(); ++n)
    u[size_t(3 * n)] = (mesh.rest(n, 0) - place) * (1 + mesh.rest(n, 1) - 2 * mesh.rest(n, 2));
  std::vector<double> filled = u;
  dependent.fill(filled.data());
  for (size_t k = 0; k < u.size(); ++k) EXPECT_NEAR(filled[k], u[k], 1e-6);
}

TEST(DependentTetNodes, HaveNoNegativeShareOfASlope) {
  // linear ones in no order, so that ways ahead point everywhere
  const ElementMesh mesh = block(Element::kTet4, 4, 4, 4, 0.3, 0.2);
  const Border border = half_space_border(true, 0.57);
  const DependentNodes dependent = followers(mesh, {border});
  ASSERT_FALSE(dependent.empty());
  for (int64_t i = 0; i < dependent.count(); ++i) {
    const double d = distance(border, rest_of(mesh, dependent.node(i)));
    double sum = 0;
    for (int64_t k = 0; k < dependent.parents(i).rows; ++k) {
      const double alpha =
          dependent.weights(i)(k) / d * distance(border, rest_of(mesh, dependent.parents(i)(k)));
      EXPECT_GE(alpha, 0);
      sum += alpha;
    }
    if (dependent.parents(i).rows > 0) {
      EXPECT_NEAR(sum, 1, 1e-12);
    }
  }
}

TEST(DependentTetNodes, AreThoseBehindAFaceOfABoxHoweverNear) {
  // a layer of nodes a hair behind the face, which no small tetrahedron sees
  Border box;
  box.lower = {-1, -1, -1};
  box.upper = {0.3001, 2, 2};
  const ElementMesh mesh = block(Element::kTet4, 3, 2, 2, 0.3);
  const DependentNodes dependent = followers(mesh, {box});
  ASSERT_EQ(dependent.count(), 9);
  for (int64_t i = 0; i < 9; ++i) EXPECT_NEAR(mesh.rest(dependent.node(i), 0), 0.3, 1e-12);
}

TEST(DependentTetNodes, AreNoneWithoutABorderInTheBody) {
  const ElementMesh mesh = block(Element::kTet4, 3, 2, 2, 0.3);
  EXPECT_TRUE(followers(mesh, {half_space_border(true, -0.01)}).empty());
  EXPECT_TRUE(followers(mesh, {}).empty());
}

}  // namespace
}  // namespace elastogen::test
