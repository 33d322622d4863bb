// SPDX-License-Identifier: Apache-2.0
// Damping on the device against the host. Nothing is here in builds without CUDA; skipped where
// there is no device.

#ifdef ELASTOGEN_CUDA

#include "tests/network/device_support.hpp"
#include "tests/network/potential/device_potential_support.hpp"
#include "tests/network/step/motion_machines.hpp"

namespace elastogen::test {
namespace {

/// The ragged block, of which one of two materials is damped.
Scene damped_ragged(Hourglass hourglass) {
  Scene scene = ragged(Law::kNeoHookean, hourglass);
  scene.materials[0].loss_factor = 0.3;
  scene.materials[0].loss_frequency = 3;
  return scene;
}

TEST_F(OnCard, DampingHasTheEnergyAndTheGradientOfTheHost) {
  for (const Hourglass hourglass : {Hourglass::kFull, Hourglass::kVariance, Hourglass::kOff}) {
    const Scene scene = damped_ragged(hourglass);
    const std::vector<double> now = bent(scene, 0.02 * kRaggedEdge, 5),
                              u = bent(scene, 0.03 * kRaggedEdge, 6);
    IncrementalPotential host(scene);
    host.begin_step(state_at(scene, now), {TimeScheme::kEuler, scene.dt, 1});
    cuda::DevicePotential device(host);
    device.begin_step(host);
    ASSERT_GT(host.evaluate<double>(u.data(), std::vector<double>(u.size()).data()).viscous, 0);
    expect_like_host<double>(host, device, u, 1e-12);
    expect_like_host<float>(host, device, u, 5e-5);
    expect_hessian_of_host(host, device, u, bent(scene, 0.5 * kRaggedEdge, 7));
  }
}

TEST_F(OnCard, DampingMeasuresFromTheStrainsOfTheHost) {
  // BDF2 measures rates from two states before
  const Scene scene = damped_ragged(Hourglass::kFull);
  State state = state_at(scene, bent(scene, 0.02 * kRaggedEdge, 5));
  const std::vector<double> before = bent(scene, 0.02 * kRaggedEdge, 9);
  state.x_before = state_at(scene, before).x;
  state.v_before = state.v;
  const StepScheme scheme{TimeScheme::kBdf2, scene.dt, 2.25};
  IncrementalPotential host(scene);
  host.begin_step(state, scheme);
  cuda::DevicePotential device(host);
  device.begin_step(host);
  OnDevice<double> now(displacement(scene, state)), other(before);
  device.begin_damping(scheme, now.data(), other.data());
  expect_like_host<double>(host, device, bent(scene, 0.03 * kRaggedEdge, 6), 1e-12);
}

TEST_F(MotionOnCard, DampedBallAndBarMoveAsOnTheHost) {
  MovingScene ball = dropped_ball(3e5, 1), bar = vibrating_bar(16, 0.02);
  for (MovingScene* m : {&ball, &bar}) {
    m->scene.materials[0].loss_factor = 0.2;
    m->scene.materials[0].loss_frequency = 5;
    // each of the default tolerances, which follow the time error, moves the ball by 6e-4 of its way
    const auto run = [&](Device device) {
      return play_exactly(device, *m, TimeScheme::kAuto, 20, 1e-6);
    };
    const std::vector<MotionFrame> host = run(Device::kCpu), card = run(Device::kCuda);
    double moved = 0;
    for (size_t k = 0; k < host.size(); ++k) {
      moved = std::max(moved, rms_distance(m->scene, host[k].state.x, m->start.x));
      EXPECT_EQ(card[k].solves, host[k].solves) << "frame " << k;
    }
    EXPECT_LT(rms_distance(m->scene, card.back().state.x, host.back().state.x), 1e-5 * moved);
  }
}

}  // namespace
}  // namespace elastogen::test

#endif
