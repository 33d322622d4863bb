// SPDX-License-Identifier: Apache-2.0
// Friction of stages: one point that a floor pushes, against closed forms.
#include "mpm_fem/contact/collider_contact.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace elastogen::test {
namespace {

using fem::ColliderContact;
using fem::ContactPoints;

constexpr double kLayer = 0.01, kArea = 0.03, kKappa = 500, kMu = 0.4;
constexpr double kBondStiffness = 10 * kArea * kKappa / (kLayer * kLayer);  // k_t [N/m]

/// A node at (0, 0, 0) above the floor y > 0, in contact where its u_y is negative.
ColliderContact point_on_floor(const Path& path = {}) {
  ContactPoints points;
  points.nodes = Array<int32_t>(1);
  points.weights = points.area = points.stiffness = Array<double>(1);
  points.weights(0) = 1, points.area(0) = kArea, points.stiffness(0) = kKappa;
  points.position = Array<double>(1, 3);
  points.layer = kLayer;
  Collider floor = half_space({0, 1, 0}, 0, kMu);
  floor.path = path;
  return ColliderContact(points, {floor}, 1);
}

Array<double> at(double x, double depth, double z = 0) {
  Array<double> u(1, 3);
  u(0, 0) = x, u(0, 1) = -depth * kLayer, u(0, 2) = z;
  return u;
}

/// Push of the barrier b = -(1-s)^2 ln s at a depth in layers [N].
double push(double depth) {
  const double s = 1 - depth;
  return kArea * kKappa / kLayer * (depth * depth / s - 2 * depth * std::log(s));
}

Array<double> gradient(ColliderContact& contact, const Array<double>& u) {
  Array<double> g(1, 3);
  contact.add_gradient(u, g);
  return g;
}

TEST(BondFriction, HoldsLikeASpringUpToMuN) {
  ColliderContact contact = point_on_floor();
  const Array<double> start = at(0, 0.5);
  contact.begin_stage(start, 0, 0.01, start, 0, {});
  const double longest = kMu * push(0.5) / kBondStiffness;
  for (const double share : {0.3, 0.99, 1.5, 40.0}) {
    const double slip = share * longest, force = kBondStiffness * std::min(slip, longest);
    const Array<double> g = gradient(contact, at(0.6 * slip, 0.5, 0.8 * slip));
    EXPECT_NEAR(g(0, 0), 0.6 * force, 1e-12 * force);
    EXPECT_NEAR(g(0, 2), 0.8 * force, 1e-12 * force);
    EXPECT_NEAR(g(0, 1), -push(0.5), 1e-12 * push(0.5));
  }
}

TEST(BondFriction, TheForceIsTheGradientAndTheHessianItsDerivative) {
  ColliderContact contact = point_on_floor();
  const Array<double> start = at(0, 0.5);
  contact.begin_stage(start, 0, 0.01, start, 0, {});
  const double longest = kMu * push(0.5) / kBondStiffness, step = 1e-6 * longest;
  for (const double share : {0.5, 3.0}) {
    const Array<double> u = at(0.6 * share * longest, 0.4, 0.8 * share * longest);
    const Array<double> g = gradient(contact, u);
    fem::SparseMatrix H = fem::pattern_of(contact.stencils(), 1);
    contact.add_hessian(u, TangentKind::kTrue, H);
    for (int j = 0; j < 3; ++j) {
      Array<double> ahead = u, behind = u;
      ahead(0, j) += step, behind(0, j) -= step;
      const double slope = (contact.energy(ahead) - contact.energy(behind)) / (2 * step);
      EXPECT_NEAR(slope, g(0, j), 1e-5 * push(0.5));
      const Array<double> up = gradient(contact, ahead), down = gradient(contact, behind);
      for (int i = 0; i < 3; ++i)
        EXPECT_NEAR(H.at(i, j), (up(0, i) - down(0, i)) / (2 * step), 1e-5 * kBondStiffness);
    }
  }
}

TEST(BondFriction, WhatYieldsIsLetGoAndTheRestComesBack) {
  ColliderContact contact = point_on_floor();
  const double longest = kMu * push(0.5) / kBondStiffness;
  Array<double> u = at(0, 0.5);
  contact.begin_stage(u, 0, 0.01, u, 0, {});
  // slides by 3 of the longest slip: two are gone
  Array<double> end = at(3 * longest, 0.5);
  Array<double> held = contact.bonds(end);
  EXPECT_NEAR(held(0, 0), longest, 1e-12 * longest);
  // in the next step the force is 0 where the bond began anew
  contact.begin_stage(end, 0.01, 0.01, end, 0.01, held);
  EXPECT_NEAR(gradient(contact, end)(0, 0), kMu * push(0.5), 1e-12 * push(0.5));
  EXPECT_NEAR(gradient(contact, at(2 * longest, 0.5))(0, 0), 0, 1e-12 * push(0.5));
  // half the way back is kept, and a point that comes off keeps nothing
  held = contact.bonds(at(2.5 * longest, 0.5));
  EXPECT_NEAR(held(0, 0), longest / 2, 1e-12 * longest);
  held = contact.bonds(at(2.5 * longest, -0.5));
  EXPECT_EQ(held(0, 0), 0);
}

TEST(BondFriction, TakesTheNormalForceOfTheEnd) {
  ColliderContact contact = point_on_floor();
  const Array<double> start = at(0, -1), end = at(1, 0.3);  // comes down and slides far
  contact.begin_stage(start, 0, 0.01, start, 0, {});
  EXPECT_EQ(gradient(contact, end)(0, 0), 0);
  EXPECT_TRUE(contact.renew_lags(end));
  EXPECT_NEAR(gradient(contact, end)(0, 0), kMu * push(0.3), 1e-12 * push(0.3));
  // it comes off again: it rubbed before, then no more
  EXPECT_TRUE(contact.renew_lags(start));
  EXPECT_FALSE(contact.renew_lags(start));
}

TEST(BondFriction, SlipIsRelativeToTheCollider) {
  ColliderContact contact = point_on_floor({{0, {}}, {1, {0.5, 0, 0}}});
  const Array<double> start = at(0, 0.5), end = at(0.005, 0.5);  // as the floor in 0.01 s
  contact.begin_stage(start, 0, 0.01, start, 0, {});
  EXPECT_NEAR(gradient(contact, end)(0, 0), 0, 1e-10 * push(0.5));
  const Array<double> v(1, 3);
  const std::vector<fem::PointForce> forces = contact.forces(end, v, v);
  ASSERT_EQ(forces.size(), 1u);
  EXPECT_NEAR(forces[0].force[1], push(0.5), 1e-12 * push(0.5));
  EXPECT_NEAR(forces[0].push, push(0.5), 1e-12 * push(0.5));
  EXPECT_NEAR(forces[0].closing, 0, 1e-12);  // the floor moves along itself
}

}  // namespace
}  // namespace elastogen::test
