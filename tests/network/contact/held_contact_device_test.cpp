// SPDX-License-Identifier: Apache-2.0
// Contact on voxels whose nodes follow others, on the device against the CPU. Nothing is here in
// builds without CUDA; skipped where there is no device.

#ifdef ELASTOGEN_CUDA

#include "network/precondition/preconditioner.hpp"
#include "tests/network/contact/contact_scenes.hpp"
#include "tests/network/held_bodies.hpp"
#include "tests/network/potential/device_potential_support.hpp"
#include "tests/network/step/moving_scenes.hpp"

namespace elastogen::test {
namespace {

using HeldContactOnCard = OnCard;

constexpr double kBottom = 0.02 - kHeldEdge;  // of the bar's voxels [m]
constexpr double kLayer = kHeldEdge / 4;      // of contact

/// The bar of swinging_bar() on a collider; points in the middle of its voxels' faces feel it, with
/// those on voxels that borders cut.
Scene bar_on(Collider collider, TimeScheme scheme) {
  Scene scene = swinging_bar(scheme, 0.3);
  scene.surface = face_points(scene.grid);
  scene.colliders = {std::move(collider)};
  finish_scene(scene);
  return scene;
}

/// On a floor that it lies in by a part of the layer.
Scene bar_on_floor(TimeScheme scheme) {
  return bar_on(half_space({0, 1, 0}, kBottom + 0.3 * kLayer, 0.3), scheme);
}

std::vector<double> followed_shake(const Scene& scene, unsigned seed) {
  return followed(scene, random_field(scene, 0.02 * kHeldEdge, seed));
}

/// Host and device in a step from a shaken state, and a displacement further on.
struct HeldInTouch {
  HeldInTouch(const Scene& scene, bool with_encoder)
      : potential(scene), u(followed_shake(scene, 3)) {
    potential.begin_step(state_at(scene, u), {TimeScheme::kEuler, scene.dt, 1});
    potential.set_nodal_rotations(u.data());
    first.emplace(potential, EncoderChoice{with_encoder});
    device.emplace(potential, EncoderChoice{with_encoder});
    device->begin_step(potential);
    const std::vector<double> away = followed_shake(scene, 4);
    for (size_t k = 0; k < u.size(); ++k) u[k] += away[k];
    device->set_nodal_rotations(u.data());  // which leaves u there
    potential.set_nodal_rotations(u.data());
  }
  IncrementalPotential potential;
  std::vector<double> u;
  std::optional<Preconditioner<float>> first;
  std::optional<cuda::DeviceQuasi> device;
};

TEST_F(HeldContactOnCard, GradientAndHessianAreThoseOfTheHost) {
  const Scene scene = bar_on_floor(TimeScheme::kEuler);
  HeldInTouch pair(scene, false);
  // what contact does to dependent nodes counts
  std::vector<double> force(pair.u.size());
  ASSERT_GT(pair.potential.contact().evaluate(pair.u.data(), force.data()), 0);
  double on_dependent = 0;
  for (int64_t i = 0; i < scene.dependent.count(); ++i)
    on_dependent += std::abs(force[size_t(3 * scene.dependent.node(i) + 1)]);
  ASSERT_GT(on_dependent, 1e-3 * norm(force));
  cuda::DevicePotential& device = pair.device->potential();
  expect_like_host<double>(pair.potential, device, pair.u, 1e-11);
  expect_like_host<float>(pair.potential, device, pair.u, 2e-5);
  expect_hessian_of_host(pair.potential, device, pair.u, followed_shake(scene, 7));
}

TEST_F(HeldContactOnCard, FirstMatrixIsThatOfTheHost) {
  for (const bool with_encoder : {false, true}) {
    const Scene scene = bar_on_floor(TimeScheme::kEuler);
    HeldInTouch pair(scene, with_encoder);
    const std::vector<double> r = random_field(scene, 1, 9);
    std::vector<double> free(r.size()), expected(r.size());
    OnDevice<double> from(r), to(r);
    pair.first->apply(r.data(), free.data());
    pair.potential.linearise_contact(pair.u.data());
    pair.first->update_contact();
    pair.first->apply(r.data(), expected.data());
    ASSERT_GT(relative_difference(free, expected), 1e-3);
    for (int pass = 0; pass < 3; ++pass) {  // the second and third are graphs
      pair.device->update_contact(true);
      pair.device->precondition(from.data(), to.data());
      EXPECT_LT(relative_difference(to.host(), expected), 2e-5);
      pair.device->update_contact(false);
      pair.device->precondition(from.data(), to.data());
      EXPECT_LT(relative_difference(to.host(), free), 2e-5);
    }
  }
}

TEST_F(HeldContactOnCard, ACarriedStartIsThatOfTheHost) {
  // a block that lifts all of the bar but its ends
  Collider lift = block({0.5, kBottom + 0.1 * kLayer - 0.2, 0.1}, {0.47, 0.2, 0.5});
  lift.path = {{0, {}}, {1.0 / 60, {0, 0.2 * kHeldEdge, 0}}};
  const Scene scene = bar_on(lift, TimeScheme::kEuler);
  IncrementalPotential potential(scene);
  cuda::DevicePotential device(potential);
  Contact& host = potential.contact();
  const std::vector<double> now(3 * size_t(scene.grid.node_count()));
  std::vector<double> carried = now, end = followed(scene, random_field(scene, kHeldEdge, 6));
  host.begin_step(now.data());
  host.carry(carried.data());
  const std::vector<double> expected = followed(scene, carried);
  EXPECT_GT(relative_difference(carried, expected), 1e-3);
  ASSERT_EQ(host.obstacle(expected.data()), nullptr);
  const double share = host.longest_step(expected.data(), end.data());
  std::vector<double> cut = end;
  for (size_t k = 0; k < cut.size(); ++k) cut[k] = expected[k] + share * (end[k] - expected[k]);
  OnDevice<double> from(now), clear(now), u(end);
  device.contact()->begin_step(from.data(), 0);
  EXPECT_EQ(device.contact()->clear_start(from.data(), clear.data(), u.data(), device.held()),
            nullptr);
  EXPECT_LT(relative_difference(clear.host(), expected), 1e-12);
  EXPECT_LT(relative_difference(u.host(), cut), 1e-12);
}

/// The state after some steps, each converged.
State run_on_floor(TimeScheme scheme, SolverMode mode, Device device) {
  const Scene scene = bar_on_floor(scheme);
  SolverOptions options;
  options.mode = mode;
  options.device = device;
  options.tolerance = 1e-6;
  options.time_error = 1e3;
  options.follows_time_error = false;
  Solver solver(scene, options);
  State state = initial_state(scene);
  double touched = 0;
  for (int k = 0; k < 8; ++k) {
    const StepReport report = solver.step(state);
    EXPECT_TRUE(report.converged) << k << ": " << report.residual << ' ' << report.refusal;
    touched = std::max(touched, report.energy.contact);
  }
  EXPECT_GT(touched, 0);
  return state;
}

TEST_F(HeldContactOnCard, RunsEndInTheStatesOfTheHostAndRepeat) {
  for (const TimeScheme scheme : {TimeScheme::kEuler, TimeScheme::kBdf2, TimeScheme::kSdirk2})
    for (const SolverMode mode : {SolverMode::kQuasi, SolverMode::kNewton}) {
      SCOPED_TRACE(concat(scheme_name(scheme), ", ", solver_name(mode)));
      const Scene scene = bar_on_floor(scheme);
      const State a = run_on_floor(scheme, mode, Device::kCpu),
                  b = run_on_floor(scheme, mode, Device::kCuda),
                  again = run_on_floor(scheme, mode, Device::kCuda);
      EXPECT_LT(distance_of_ways(scene, b, a), 1e-5);
      EXPECT_EQ(b.x, again.x);
      EXPECT_EQ(b.v, again.v);
      const std::vector<double> u = displacement(scene, b), exact = followed(scene, u);
      for (size_t k = 0; k < u.size(); ++k) EXPECT_NEAR(u[k], exact[k], 1e-15);
    }
}

}  // namespace
}  // namespace elastogen::test

#endif
