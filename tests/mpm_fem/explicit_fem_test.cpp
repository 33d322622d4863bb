// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/integrators/explicit_fem.hpp"

#include "core/error.hpp"
#include "mpm_fem/integrators/implicit_fem.hpp"
#include "tests/mpm_fem/scenes.hpp"

#include <gtest/gtest.h>

namespace elastogen {
namespace {

using fem::ExplicitFem;
using fem::FemState;
using test::Element;
using test::FemScene;

/// A block on or above the half-space y < 0, whose nodes touch it.
FemScene over_floor(double friction) {
  FemScene scene = test::scene_of(test::block(Element::kTet4, 2, 1, 2, 0.1),
                                  test::solid(Law::kHencky, 1e5, 0.3, 1000));
  scene.dt = 1e-4;
  scene.colliders = {half_space({0, 1, 0}, 0, friction)};
  const int64_t count = scene.mesh.rest.rows();
  fem::ContactPoints& points = scene.contact;
  points.nodes = Array<int32_t>(count);
  points.weights = points.area = points.stiffness = Array<double>(count);
  points.position = scene.mesh.rest;
  for (int64_t n = 0; n < count; ++n) points.nodes(n) = int32_t(n);
  points.weights.fill(1), points.area.fill(5e-3), points.stiffness.fill(1e4);
  points.layer = 0.01, points.slip_range = 1e-6;
  return scene;
}

TEST(ExplicitFem, FreeFallIsThatOfSymplecticEuler) {
  FemScene scene = over_floor(0);
  scene.colliders.clear();
  scene.gravity = {0, -test::kGravity, 0};
  ExplicitFem solver(scene);
  FemState state = rest_state(scene);
  for (int k = 0; k < 100; ++k) solver.step(state);
  // v = n dt g, u = n (n + 1)/2 dt^2 g
  for (int64_t n = 0; n < state.u.rows(); ++n) {
    EXPECT_NEAR(state.v(n, 1), -100 * 1e-4 * test::kGravity, 1e-12);
    EXPECT_NEAR(state.u(n, 1), -100 * 101 / 2 * 1e-8 * test::kGravity, 1e-12);
  }
}

TEST(ExplicitFem, MetalInFlightKeepsTheMomentum) {
  FemScene scene = over_floor(0);
  scene.colliders.clear();
  scene.yields = {MetalYield{.stress = 1e3, .hardening = 1e3}};
  ExplicitFem solver(scene);
  FemState state = rest_state(scene);
  test::Random random(2);
  std::normal_distribution<double> normal(0, 1);
  for (int64_t k = 0; k < state.v.size(); ++k) state.v.data()[k] = normal(random);
  const Array<double> mass = fem::ElasticBody(scene.mesh, scene.materials).lumped_mass();
  const auto momentum = [&](int d) {
    double sum = 0;
    for (int64_t n = 0; n < mass.rows(); ++n) sum += mass(n) * state.v(n, d);
    return sum;
  };
  const double before[3] = {momentum(0), momentum(1), momentum(2)};
  for (int k = 0; k < 300; ++k) solver.step(state);
  for (int d = 0; d < 3; ++d) EXPECT_NEAR(momentum(d), before[d], 1e-10);
}

TEST(ExplicitFem, ABlockSlidesToRestAsCoulombSays) {
  FemScene scene = over_floor(0.5);
  scene.gravity = {0, -test::kGravity, 0};
  FemState start = rest_state(scene);
  ExplicitFem solver(scene);
  // settled first, without sliding
  for (int k = 0; k < 5000; ++k) {
    solver.step(start);
    for (int64_t j = 0; j < start.v.size(); ++j) start.v.data()[j] *= 0.99;
  }
  FemState state = start;
  for (int64_t n = 0; n < state.v.rows(); ++n) state.v(n, 0) += 0.5;
  const double from = test::total(state.u, 0);
  for (int k = 0; k < 1500; ++k) solver.step(state);
  const double stopped = test::total(state.u, 0);
  for (int k = 0; k < 500; ++k) solver.step(state);
  // v^2/(2 mu g), and no farther
  const double way = (test::total(state.u, 0) - from) / double(state.u.rows());
  EXPECT_NEAR(way, 0.25 / (2 * 0.5 * test::kGravity), 0.05 * way);
  EXPECT_NEAR(test::total(state.u, 0) / double(state.u.rows()), stopped / double(state.u.rows()),
              0.02 * way);
}

TEST(ExplicitFem, ComesToTheSameFlowAsFineImplicitSteps) {
  // a bar whose end is pulled beyond yield within a few periods of its slowest vibration
  FemScene scene = test::scene_of(test::block(Element::kHex, 3, 1, 1, 0.1),
                                  test::solid(Law::kHencky, 1e6, 0.3, 1000));
  scene.yields = {MetalYield{.stress = 5e3, .hardening = 1e5}};
  test::clamp(scene, 0, 0);
  test::fix(scene, 0, 0.3, 0);
  const std::vector<int64_t> end = test::plane(scene.mesh, 0, 0.3);
  scene.motion = [&](double time, Out<double> u) {
    for (const int64_t n : end) u(n, 0) = 0.3 * time;
  };
  const auto run = [&](auto& solver, double dt) {
    scene.dt = dt;
    FemState state = rest_state(scene);
    for (int k = 0; k < std::lround(0.05 / dt); ++k) solver.step(state);
    return state.u;
  };
  scene.dt = 1e-5;
  ExplicitFem steps(scene);
  const Array<double> u = run(steps, 1e-5);
  double coarse = 0, fine = 0;
  for (double* error : {&coarse, &fine}) {
    scene.dt = error == &coarse ? 4e-4 : 2e-4;
    fem::ImplicitFem solver(scene);
    const Array<double> other = run(solver, scene.dt);
    for (int64_t k = 0; k < u.size(); ++k)
      *error = std::max(*error, std::abs(u.data()[k] - other.data()[k]));
  }
  EXPECT_LT(fine, 0.005 * 0.015);
  EXPECT_NEAR(coarse / fine, 2, 0.5);  // the error is the implicit scheme's, of first order
}

TEST(ExplicitFem, RejectsWhatItsDocumentationForbids) {
  FemScene scene = over_floor(0);
  scene.mass_kind = fem::Mass::kConsistent;
  EXPECT_THROW(ExplicitFem{scene}, Error);
  scene.mass_kind = fem::Mass::kLumped;
  scene.dt = 0;
  EXPECT_THROW(ExplicitFem{scene}, Error);
  scene.dt = 1e-4;
  scene.contact.nodes = Array<int32_t>(scene.mesh.rest.rows(), 2);
  scene.contact.weights = Array<double>(scene.mesh.rest.rows(), 2);
  EXPECT_THROW(ExplicitFem{scene}, Error);
}

}  // namespace
}  // namespace elastogen
