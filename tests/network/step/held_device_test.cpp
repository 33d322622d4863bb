// SPDX-License-Identifier: Apache-2.0
// Bodies held at borders that cut voxels (held_test.cpp) on the device against the CPU. Nothing is
// here in builds without CUDA; skipped where there is no device.

#ifdef ELASTOGEN_CUDA

#include "tests/network/fixed_scenes.hpp"
#include "tests/network/potential/device_potential_support.hpp"
#include "tests/network/step/moving_scenes.hpp"

namespace elastogen::test {
namespace {

using HeldOnCard = OnCard;

constexpr double kShake = 0.03 * kHeldEdge;

/// Random displacements that meet the borders.
std::vector<double> held_shake(const Scene& scene, unsigned seed) {
  return followed(scene, random_field(scene, kShake, seed));
}

std::vector<Scene> held_scenes() {
  return {swinging_bar(TimeScheme::kBdf2), swinging_bar(TimeScheme::kEuler, 0.3),
          block_on_ball(TimeScheme::kEuler), sliding_bar(TimeScheme::kBdf2)};
}

TEST_F(HeldOnCard, GradientHessianAndResidualAreThoseOfTheHost) {
  for (const Scene& scene : held_scenes())
    for (const double loss : {0.0, 0.1}) {
      SCOPED_TRACE(concat(scene.grid.voxel_count(), " voxels, loss factor ", loss));
      Scene damped = scene;
      damped.materials[0].loss_factor = loss;
      ASSERT_FALSE(damped.dependent.empty());
      const std::vector<double> u = held_shake(damped, 6);
      IncrementalPotential host(damped);
      host.begin_step(state_at(damped, held_shake(damped, 5)), {TimeScheme::kEuler, damped.dt, 1});
      cuda::DevicePotential device(host);
      device.begin_step(host);
      expect_like_host<double>(host, device, u, 1e-11);
      expect_like_host<float>(host, device, u, 2e-5);
      expect_hessian_of_host(host, device, u, held_shake(damped, 7));
      // dependent nodes have no gradient of their own
      OnDevice<double> place(u), gradient(std::vector<double>(u.size(), 7));
      device.start_residual(place.data(), gradient.data());
      std::vector<double> expected(u.size());
      host.residual(u.data(), expected.data());
      const std::vector<double> found = gradient.host();
      EXPECT_LT(relative_difference(found, expected), 1e-11);
      for (int64_t i = 0; i < damped.dependent.count(); ++i)
        for (int d = 0; d < 3; ++d) EXPECT_EQ(found[size_t(3 * damped.dependent.node(i) + d)], 0);
    }
}

TEST_F(HeldOnCard, FirstMatrixIsThatOfTheHost) {
  for (const Scene& scene : held_scenes())
    for (const bool with_encoder : {false, true}) {
      SCOPED_TRACE(concat(scene.grid.voxel_count(), " voxels, encoder ", with_encoder));
      const std::vector<double> now = held_shake(scene, 5), r = random_field(scene, 1, 9);
      IncrementalPotential host(scene);
      host.begin_step(state_at(scene, now), {TimeScheme::kEuler, scene.dt, 1});
      host.set_nodal_rotations(now.data());
      Preconditioner<float> first(host, EncoderChoice{with_encoder}, cuda::kDenseNodes);
      cuda::DeviceQuasi device(host, EncoderChoice{with_encoder});
      device.begin_step(host);
      device.set_nodal_rotations(now.data());
      std::vector<double> expected(r.size());
      first.apply(r.data(), expected.data());
      OnDevice<double> from(r), to(std::vector<double>(r.size()));
      for (int pass = 0; pass < 3; ++pass) {  // the second and third are graphs
        device.precondition(from.data(), to.data());
        EXPECT_LT(relative_difference(to.host(), expected), 2e-5);
      }
      EXPECT_LT(relative_difference(followed(scene, to.host()), to.host()), 1e-15);
    }
}

struct HeldRun {
  State state;
  StepReport last;
  std::vector<double> residual;
};

/// Steps of equal length, whatever their time error.
HeldRun run_held(const Scene& scene, SolverMode mode, Device device, const State& from, int steps) {
  SolverOptions options;
  options.mode = mode;
  options.device = device;
  options.tolerance = 1e-6;
  options.time_error = 1e3;
  options.follows_time_error = false;
  Solver solver(scene, options);
  EXPECT_EQ(solver.device() == "cpu", device == Device::kCpu);
  HeldRun run{from, {}, {}};
  for (int k = 0; k < steps; ++k) {
    run.last = solver.step(run.state);
    EXPECT_TRUE(run.last.converged) << k << ": " << run.last.residual;
  }
  const Span<const double> g = solver.residual();
  run.residual.assign(g.data, g.data + g.size());
  return run;
}

/// The state meets the borders to the rounding of positions.
void expect_constraints(const Scene& scene, const State& state) {
  const std::vector<double> u = displacement(scene, state), exact = followed(scene, u),
                            v(state.v.data(), state.v.data() + state.v.size()),
                            exact_v = followed(scene, v);
  for (size_t k = 0; k < u.size(); ++k) {
    EXPECT_NEAR(u[k], exact[k], 1e-15);
    EXPECT_NEAR(v[k], exact_v[k], 1e-12 * norm(v));
  }
}

TEST_F(HeldOnCard, StepsOfAllSchemesAndSolversAreThoseOfTheHost) {
  for (const TimeScheme scheme :
       {TimeScheme::kEuler, TimeScheme::kBdf2, TimeScheme::kSdirk2, TimeScheme::kAuto})
    for (const SolverMode mode : {SolverMode::kQuasi, SolverMode::kNewton}) {
      SCOPED_TRACE(concat(scheme_name(scheme), ", ", solver_name(mode)));
      const Scene scene = swinging_bar(scheme);
      const State from = bar_in_motion(scene);
      const HeldRun a = run_held(scene, mode, Device::kCpu, from, 12);
      const HeldRun b = run_held(scene, mode, Device::kCuda, from, 12);
      EXPECT_EQ(b.state.time, a.state.time);
      EXPECT_LT(distance_of_ways(scene, b.state, a.state), 1e-6);
      EXPECT_LT(relative_difference(b.state.v, a.state.v), 1e-5);
      EXPECT_NEAR(b.last.energy.kinetic, a.last.energy.kinetic, 1e-4 * a.last.energy.kinetic);
      EXPECT_NEAR(b.last.energy.gravity, a.last.energy.gravity,
                  1e-6 * std::abs(a.last.energy.gravity));
      EXPECT_LE(norm(b.residual), 1e-6 * reference_force(scene));
      EXPECT_LE(b.last.inner, 4 + 1.3 * a.last.inner);
      expect_constraints(scene, b.state);
    }
}

TEST_F(HeldOnCard, ABlockOnABallSwingsAsOnTheHost) {
  for (const SolverMode mode : {SolverMode::kQuasi, SolverMode::kNewton}) {
    const Scene scene = block_on_ball(TimeScheme::kEuler);
    const State from = initial_state(scene);
    const HeldRun a = run_held(scene, mode, Device::kCpu, from, 6);
    const HeldRun b = run_held(scene, mode, Device::kCuda, from, 6);
    EXPECT_LT(distance_of_ways(scene, b.state, a.state), 1e-6);
    expect_constraints(scene, b.state);
  }
}

TEST_F(HeldOnCard, TheHostFindsTheResidualOfItsState) {
  for (const SolverMode mode : {SolverMode::kQuasi, SolverMode::kNewton}) {
    const Scene scene = swinging_bar(TimeScheme::kBdf2);
    const State from = bar_in_motion(scene);
    IncrementalPotential potential(scene);
    potential.begin_step(from, step_scheme(scene, from));
    const HeldRun run = run_held(scene, mode, Device::kCuda, from, 1);
    std::vector<double> gradient(run.residual.size());
    const PotentialValue value =
        potential.residual(displacement(scene, run.state).data(), gradient.data());
    const double force = reference_force(scene);
    EXPECT_NEAR(run.last.residual, norm(gradient) / force, 1e-9);
    for (size_t k = 0; k < gradient.size(); ++k)
      EXPECT_NEAR(run.residual[k], gradient[k], 1e-9 * force);
    EXPECT_NEAR(run.last.energy.elastic, value.elastic, 1e-9 * value.elastic);
  }
}

TEST_F(HeldOnCard, RunsRepeatToTheBit) {
  for (const TimeScheme scheme : {TimeScheme::kBdf2, TimeScheme::kAuto})
    for (const SolverMode mode : {SolverMode::kQuasi, SolverMode::kNewton}) {
      const Scene scene = swinging_bar(scheme);
      const State from = bar_in_motion(scene);
      const HeldRun a = run_held(scene, mode, Device::kCuda, from, 10),
                    b = run_held(scene, mode, Device::kCuda, from, 10);
      EXPECT_EQ(a.state.x, b.state.x);
      EXPECT_EQ(a.state.v, b.state.v);
      EXPECT_EQ(a.residual, b.residual);
    }
}

TEST_F(HeldOnCard, AFreePieceFliesBesideAHeldOne) {
  // a block beside the bar that falls
  Surface surface = box_surface({0, 0, 0}, {1, 0.2, 0.2});
  const Surface other = box_surface({0.3, 0.4, 0}, {0.6, 0.6, 0.2});
  Surface both = surface;
  both.vertices = Array<double>(16, 3);
  both.triangles = Array<int32_t>(24, 3);
  both.material = Array<int32_t>(24);
  for (int k = 0; k < 24; ++k) {
    both.vertices.data()[k] = surface.vertices.data()[k];
    both.vertices.data()[24 + k] = other.vertices.data()[k];
  }
  for (int k = 0; k < 36; ++k) {
    both.triangles.data()[k] = surface.triangles.data()[k];
    both.triangles.data()[36 + k] = other.triangles.data()[k] + 8;
  }
  both.box.add({0.6, 0.6, 0.2});
  Scene scene = held_scene(both, {half_space_border(true, 0.01), half_space_border(false, 0.99)},
                           kHeldEdge, {0.01 - 0.7 * kHeldEdge, 0.02, 0.02}, 1.0 / 60);
  scene.materials[0] = solid(2e5, 0.3);
  finish_scene(scene);
  ASSERT_EQ(scene.grid.pieces, 2);
  const State from = initial_state(scene);
  for (const SolverMode mode : {SolverMode::kQuasi, SolverMode::kNewton}) {
    const HeldRun a = run_held(scene, mode, Device::kCpu, from, 8);
    const HeldRun b = run_held(scene, mode, Device::kCuda, from, 8);
    EXPECT_LT(distance_of_ways(scene, b.state, a.state), 1e-6);
    EXPECT_LT(relative_difference(b.state.v, a.state.v), 1e-5);
    expect_constraints(scene, b.state);
  }
}

TEST_F(HeldOnCard, AutoTakesTheCardToo) {
  const Scene scene = swinging_bar(TimeScheme::kAuto);
  SolverOptions options;
  options.device = Device::kAuto;
  EXPECT_NE(Solver(scene, options).device(), "cpu");
}

}  // namespace
}  // namespace elastogen::test

#endif
