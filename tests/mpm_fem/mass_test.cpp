// SPDX-License-Identifier: Apache-2.0
// Masses and volumes against the moments of the box.

#include "tests/mpm_fem/bodies.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace elastogen {
namespace {

using test::ElasticBody;
using test::Element;
using test::ElementMesh;
using test::Random;

constexpr Element kBodyFitted[5] = {Element::kHex, Element::kHexBbar, Element::kTet4,
                                    Element::kTet10, Element::kTet10Bbar};
constexpr double kRho = 1000, kSize[3] = {0.6, 0.4, 0.4};

/// 3 x 2 x 2 cubes of edge 0.2 with moved inner nodes.
ElasticBody distorted_box(Element element) {
  return {test::block(element, 3, 2, 2, 0.2, 0.25), {test::solid()}};
}

/// p^T M q of the nodal values of two functions of position.
template <class P, class Q>
double product(const ElasticBody& body, const P& p, const Q& q) {
  const ElementMesh& mesh = body.mesh();
  const int nodes = fem::nodes_of(mesh.element);
  double sum = 0;
  for (int64_t e = 0; e < mesh.elements.rows(); ++e) {
    double M[fem::kMaxNodes * fem::kMaxNodes];
    body.element_mass(e, M);
    for (int a = 0; a < nodes; ++a)
      for (int b = 0; b < nodes; ++b)
        sum += p(test::rest_of(mesh, mesh.elements(e, a))) * M[nodes * a + b] *
               q(test::rest_of(mesh, mesh.elements(e, b)));
  }
  return sum;
}

/// Density times the integral of x^i y^j z^k over the box.
double box_moment(int i, int j, int k) {
  const int power[3] = {i, j, k};
  double moment = kRho;
  for (int d = 0; d < 3; ++d) moment *= std::pow(kSize[d], power[d] + 1) / (power[d] + 1);
  return moment;
}

TEST(Mass, ConsistentMassHasTheMomentsOfTheBoxOnDistortedMeshes) {
  const auto one = [](const Vec3&) { return 1.0; };
  const auto x = [](const Vec3& X) { return X[0]; };
  const auto y = [](const Vec3& X) { return X[1]; };
  for (const Element element : kBodyFitted) {
    const ElasticBody body = distorted_box(element);
    EXPECT_NEAR(product(body, one, one) / box_moment(0, 0, 0), 1, 1e-13);
    EXPECT_NEAR(product(body, one, x) / box_moment(1, 0, 0), 1, 1e-13);
    EXPECT_NEAR(product(body, x, x) / box_moment(2, 0, 0), 1, 1e-13);
    EXPECT_NEAR(product(body, x, y) / box_moment(1, 1, 0), 1, 1e-13);
  }
}

TEST(Mass, ConsistentMassOfQuadraticTetrahedraHasTheFourthMoments) {
  const auto xx = [](const Vec3& X) { return X[0] * X[0]; };
  const auto yz = [](const Vec3& X) { return X[1] * X[2]; };
  const ElasticBody body = distorted_box(Element::kTet10);
  EXPECT_NEAR(product(body, xx, xx) / box_moment(4, 0, 0), 1, 1e-13);
  EXPECT_NEAR(product(body, xx, yz) / box_moment(2, 1, 1), 1, 1e-13);
  EXPECT_NEAR(product(body, yz, yz) / box_moment(0, 2, 2), 1, 1e-13);
}

TEST(Mass, LumpedMassIsPositiveAndHasMassAndCentreOfTheBox) {
  for (const Element element : kBodyFitted) {
    const ElasticBody body = distorted_box(element);
    const Array<double> mass = body.lumped_mass();
    double total = 0, first = 0;
    for (int64_t n = 0; n < mass.rows(); ++n) {
      EXPECT_GT(mass(n), 0);
      total += mass(n), first += mass(n) * body.mesh().rest(n, 0);
    }
    EXPECT_NEAR(total / box_moment(0, 0, 0), 1, 1e-13) << fem::element_name(element);
    EXPECT_NEAR(first / box_moment(1, 0, 0), 1, 1e-13) << fem::element_name(element);
  }
}

TEST(Mass, LumpedMassOfAQuadraticTetrahedronIsHintonsShare) {
  // 1/36 of the mass for a corner, 4/27 for the middle of an edge
  const ElasticBody body(test::first_element(test::block(Element::kTet10, 1, 1, 1, 0.5)),
                         {test::solid()});
  const Array<double> mass = body.lumped_mass();
  const double total = kRho * 0.125 / 6;
  for (int a = 0; a < 10; ++a) EXPECT_NEAR(mass(a) / total, a < 4 ? 1 / 36.0 : 4 / 27.0, 1e-14);
}

TEST(Mass, LumpedMassOfVoxelsIsThatOfTheScene) {
  Random random(1);
  std::uniform_real_distribution<double> unit(0.02, 1);
  VoxelGrid grid = make_box(3, 2, 2, 0.3);
  grid.volume = 0;
  for (int64_t v = 0; v < grid.voxel_count(); ++v) {
    grid.fill(v) = unit(random);
    const double place[3] = {unit(random), unit(random), unit(random)};
    for (int c = 0; c < 8; ++c) {
      grid.shape_mean(v, c) = 1;
      for (int d = 0; d < 3; ++d) grid.shape_mean(v, c) *= c >> d & 1 ? place[d] : 1 - place[d];
    }
  }
  const Scene scene = test::voxel_scene(grid, test::solid());
  for (const Element element : {Element::kVoxel, Element::kHex, Element::kHexBbar}) {
    const ElasticBody body(fem::voxel_mesh(scene, element), scene.materials);
    const Array<double> mass = body.lumped_mass();
    for (int64_t n = 0; n < mass.rows(); ++n) EXPECT_NEAR(mass(n) / scene.mass(n), 1, 1e-14) << n;
    // the consistent one has the same total
    const auto one = [](const Vec3&) { return 1.0; };
    double total = 0;
    for (int64_t n = 0; n < mass.rows(); ++n) total += mass(n);
    EXPECT_NEAR(product(body, one, one) / total, 1, 1e-13);
  }
}

TEST(Mass, VolumesSumToThatOfTheBox) {
  for (const Element element : kBodyFitted) {
    const Array<double> volume = distorted_box(element).volume();
    double total = 0;
    for (int64_t e = 0; e < volume.rows(); ++e) total += volume(e);
    EXPECT_NEAR(total, 0.096, 1e-15) << fem::element_name(element);
  }
  Random random(2);
  EXPECT_NEAR(ElasticBody(test::one_voxel(random, Hourglass::kFull), {test::solid()}).volume()(0),
              0.4, 1e-15);
}

}  // namespace
}  // namespace elastogen
