// SPDX-License-Identifier: Apache-2.0
// Motion by stages and by steps that follow their time error, at the default tolerance of the
// solver, against closed forms and against runs of the CPU with 16 or 32 steps a frame.
#include "core/error.hpp"
#include "tests/network/step/motion_machines.hpp"

namespace elastogen::test {
namespace {

double size_of(const Vec3& v) {
  return safe_norm(v);
}

/// Angle that a piece has turned about z, from the mean over its nodes.
double angle_about_z(const Scene& scene, const State& state) {
  const MeanMotion rest = mean_motion(scene, initial_state(scene)), now = mean_motion(scene, state);
  double sine = 0, cosine = 0;
  for (int64_t n = 0; n < scene.grid.node_count(); ++n) {
    const double X = scene.grid.rest(n, 0) - rest.centre[0],
                 Y = scene.grid.rest(n, 1) - rest.centre[1], x = state.x(n, 0) - now.centre[0],
                 y = state.x(n, 1) - now.centre[1];
    cosine += scene.mass(n) * (X * x + Y * y);
    sine += scene.mass(n) * (X * y - Y * x);
  }
  return std::atan2(sine, cosine);
}

void expect_free_fall(Device device) {
  MovingScene m = block_on_floor(1e5, 100);
  m.start = initial_state(m.scene, {.velocity = {1, 2, 0.5}});
  const MeanMotion begin = mean_motion(m.scene, m.start);
  for (const TimeScheme scheme : {kSdirk2, kAuto}) {
    const std::vector<MotionFrame> run = play_on(device, m, scheme, 30);
    const MeanMotion end = mean_motion(m.scene, run.back().state);
    const double t = 30 * kFrame;
    EXPECT_NEAR(end.centre[1] - begin.centre[1], 2 * t - 9.81 * t * t / 2, 1e-12);
    EXPECT_NEAR(end.velocity[1], 2 - 9.81 * t, 1e-12);
    EXPECT_NEAR(end.centre[0] - begin.centre[0], t, 1e-12);
    if (scheme == kAuto) {
      EXPECT_LE(solves_a_frame(run), 1.1);
    }
  }
}

void expect_spin(Device device) {
  // a ball of rate 10 rad/s: after 60 frames 20 rad, of a soft one less, as it widens
  struct Case {
    double courant, off, solves;  // off: the angle [rad]
  };
  for (const Case& c : {Case{5, 0.02, 2.2}, Case{50, 1e-3, 1.1}}) {
    const MovingScene m = spinning_ball(c.courant, 10);
    const std::vector<MotionFrame> run = play_on(device, m, kAuto, 60),
                                   fine = play(m, kSdirk2, 60, 8);
    const Vec3 before = mean_motion(m.scene, m.start).spin,
               after = mean_motion(m.scene, run.back().state).spin;
    EXPECT_LT(size_of(minus(after, before)), 1e-12 * size_of(before));
    const double turned = angle_about_z(m.scene, run.back().state) + 6 * std::numbers::pi,
                 exact = angle_about_z(m.scene, fine.back().state) + 6 * std::numbers::pi;
    printf("spin, C %g: %.4f rad, %.4f with fine steps, %.2f solves a frame\n", c.courant, turned,
           exact, solves_a_frame(run));
    EXPECT_NEAR(turned, exact, c.off);
    EXPECT_LE(solves_a_frame(run), c.solves);
  }
}

void expect_tumbling(Device device) {
  const MovingScene m = tumbling_box(50, 6);
  const std::vector<MotionFrame> run = play_on(device, m, kAuto, 60),
                                 fine = play(m, kSdirk2, 60, 16);
  const Vec3 before = mean_motion(m.scene, m.start).spin,
             after = mean_motion(m.scene, run.back().state).spin;
  EXPECT_LT(size_of(minus(after, before)), 1e-12 * size_of(before));
  const double size = 0.4;
  EXPECT_LT(rms_distance(m.scene, run.back().state.x, fine.back().state.x), 0.002 * size / 2);
  EXPECT_LE(solves_a_frame(run), 1.1);
}

void expect_two_pieces(Device device) {
  // two blocks side by side that do not touch, of which one spins: each keeps its own momentum
  const double h = 0.05;
  std::vector<std::array<int32_t, 3>> at;
  for (int k = 0; k < 2; ++k)
    for (int x = 0; x < 3; ++x)
      for (int y = 0; y < 3; ++y)
        for (int z = 0; z < 3; ++z) at.push_back({x + 20 * k, y, z});
  Array<int32_t> list(int64_t(at.size()), 3);
  for (size_t v = 0; v < at.size(); ++v)
    std::copy(at[v].begin(), at[v].end(), list.row(int64_t(v)));
  MovingScene m{scene_on(make_grid(list, h, {}), solid(young_of_frame(20, h), 0.3)), {}};
  ASSERT_EQ(m.scene.grid.pieces, 2);
  finish_scene(m.scene);
  m.start = initial_state(m.scene);
  for (int64_t n = 0; n < m.scene.grid.node_count(); ++n)
    if (m.scene.grid.piece(n) == 0) {
      m.start.v(n, 0) = -8 * (m.scene.grid.rest(n, 1) - 1.5 * h);
      m.start.v(n, 1) = 8 * (m.scene.grid.rest(n, 0) - 1.5 * h);
    }
  const std::vector<MotionFrame> run = play_on(device, m, kAuto, 30);
  double moved = 0;
  for (int64_t n = 0; n < m.scene.grid.node_count(); ++n)
    if (m.scene.grid.piece(n) == 1)
      for (int d = 0; d < 3; ++d)
        moved = std::max(moved, std::abs(run.back().state.x(n, d) - m.scene.grid.rest(n, d)));
  EXPECT_LT(moved, 1e-12);
  const Vec3 before = mean_motion(m.scene, m.start).spin,
             after = mean_motion(m.scene, run.back().state).spin;
  EXPECT_LT(size_of(minus(after, before)), 1e-12 * size_of(before));
}

/// Amplitude at the end of a vibrating bar's run over that of another, and relative difference of
/// the periods.
std::pair<double, double> compared(const Scene& scene, const std::vector<MotionFrame>& run,
                                   const std::vector<MotionFrame>& fine) {
  const auto measure = [&](const std::vector<MotionFrame>& frames) {
    std::vector<double> q;
    for (const MotionFrame& f : frames) {
      double sum = 0;
      for (int64_t n = 0; n < scene.grid.node_count(); ++n)
        sum += scene.mass(n) * std::cos(std::numbers::pi * scene.grid.rest(n, 0) / 0.8) *
               (f.state.x(n, 0) - scene.grid.rest(n, 0));
      q.push_back(sum);
    }
    std::vector<double> zeros;
    double amplitude = 0;
    for (size_t k = 1; k < q.size(); ++k) {
      if ((q[k] > 0) != (q[k - 1] > 0)) zeros.push_back(double(k) - q[k] / (q[k] - q[k - 1]));
      if (k + 16 >= q.size()) amplitude = std::max(amplitude, std::abs(q[k]));
    }
    return std::pair(amplitude, (zeros.back() - zeros.front()) / double(zeros.size() - 1));
  };
  const auto [a, period] = measure(run);
  const auto [b, exact] = measure(fine);
  return {a / b, period / exact - 1};
}

void expect_ringing(Device device) {
  struct Case {
    double frames, amplitude, period, solves;
  };
  for (const Case& c : {Case{16, 0.92, 0.025, 2.3}, Case{8, 0.9, 0.02, 4.6}}) {
    const MovingScene m = vibrating_bar(c.frames, 0.02);
    const std::vector<MotionFrame> run = play_on(device, m, kAuto, 60),
                                   fine = play(m, kSdirk2, 60, 16);
    const auto [amplitude, period] = compared(m.scene, run, fine);
    printf("bar of %g frames: amplitude %.3f, period %+.2f %%, %.2f solves a frame\n", c.frames,
           amplitude, 100 * period, solves_a_frame(run));
    EXPECT_GT(amplitude, c.amplitude);
    EXPECT_LT(amplitude, 1.02);
    EXPECT_LT(std::abs(period), c.period);
    EXPECT_LE(solves_a_frame(run), c.solves);
  }
}

void expect_swing(Device device) {
  struct Case {
    MovingScene m;
    double error, solves;  // of the centre over its range
  };
  for (const Case& c : {Case{released_cantilever(3e5), 0.04, 3}, Case{pendulum(1.2), 0.02, 2.4}}) {
    const std::vector<MotionFrame> run = play_on(device, c.m, kAuto, 60),
                                   fine = play(c.m, kSdirk2, 60, 16);
    double error = 0, low = 1e300, high = -1e300;
    for (size_t k = 0; k < run.size(); ++k) {
      const Vec3 a = mean_motion(c.m.scene, run[k].state).centre,
                 b = mean_motion(c.m.scene, fine[k].state).centre;
      error = std::max(error, size_of(minus(a, b)));
      low = std::min(low, b[1]), high = std::max(high, b[1]);
    }
    printf("swing: centre off by %.2f %% of its range, %.2f solves a frame\n",
           100 * error / (high - low), solves_a_frame(run));
    EXPECT_LT(error, c.error * (high - low));
    EXPECT_LE(solves_a_frame(run), c.solves);
  }
}

TEST(Motion, FreeFallIsExact) {
  expect_free_fall(Device::kCpu);
}

TEST(Motion, ASpinKeepsItsMomentumAndItsAngle) {
  expect_spin(Device::kCpu);
}

TEST(Motion, ATumblingBoxFollowsEulersEquations) {
  expect_tumbling(Device::kCpu);
}

TEST(Motion, ASpinningPieceOfTwoIsNotTheOther) {
  expect_two_pieces(Device::kCpu);
}

TEST(Motion, ACantileverAndAPendulumSwingAsFineStepsSay) {
  expect_swing(Device::kCpu);
}

TEST(Motion, BarsKeepRinging) {
  expect_ringing(Device::kCpu);
}

TEST(Motion, TheEstimateIsTheLocalErrorWithinAFactor) {
  // frames of the pendulum, each against 16 steps from its start; it is stiff, so that S, which drops
  // what a frame cannot show, drops nothing
  const MovingScene m = pendulum(1.2);
  Scene coarse = m.scene, fine = m.scene;
  coarse.scheme = kAuto, fine.scheme = kSdirk2;
  coarse.dt = kFrame, fine.dt = kFrame / 16;
  finish_scene(coarse), finish_scene(fine);
  Solver solver(coarse, {.tolerance = 1e-5, .time_error = 0.02}),
      reference(fine, {.tolerance = 1e-5});
  State state = m.start;
  std::vector<double> ratios;
  for (int frame = 0; frame < 40; ++frame) {
    State exact = state;
    exact.x_before = exact.v_before = {};
    exact.time = 0, exact.steps = 0;
    double estimate = 0;
    for (bool complete = false; !complete;) {
      const StepReport r = solver.step(state);
      ASSERT_TRUE(r.converged);
      estimate += r.time_error;
      complete = r.completes;
    }
    for (int k = 0; k < 16; ++k) ASSERT_TRUE(reference.step(exact).converged);
    const double error = rms_distance(coarse, state.x, exact.x);
    if (frame > 2 && error > 1e-6) ratios.push_back(estimate / error);
  }
  std::sort(ratios.begin(), ratios.end());
  const double median = ratios[ratios.size() / 2], low = ratios[ratios.size() / 10];
  printf("estimate over local error: median %.2f, %.2f ... %.2f\n", median, ratios.front(),
         ratios.back());
  EXPECT_GT(median, 0.7);
  EXPECT_LT(median, 1.9);
  EXPECT_GT(low, 0.4);
}

TEST(Motion, OneRunIsAnotherContinuedFromItsState) {
  const MovingScene m = released_cantilever(3e5);
  Scene scene = m.scene;
  scene.scheme = kAuto, scene.dt = kFrame;
  finish_scene(scene);
  Solver one(scene, {.tolerance = 1e-6}), other(scene, {.tolerance = 1e-6});
  State state = m.start;
  for (int k = 0; k < 12; ++k) ASSERT_TRUE(one.step(state).converged);
  State again = state;
  other.begin(again);  // knows nothing but the state
  for (int k = 0; k < 6; ++k) {
    ASSERT_TRUE(one.step(state).converged);
    ASSERT_TRUE(other.advance().converged);
  }
  other.read(again);
  EXPECT_LT(rms_distance(scene, state.x, again.x), 1e-3);
}

TEST(Motion, ThePapersAlgorithmIsRefused) {
  Scene scene = released_cantilever(3e5).scene;
  scene.scheme = kAuto;
  EXPECT_THROW(Solver(scene, {.mode = SolverMode::kPaper}), Error);
}

#ifdef ELASTOGEN_CUDA

TEST_F(MotionOnCard, FreeFallIsExact) {
  expect_free_fall(Device::kCuda);
}

TEST_F(MotionOnCard, ASpinKeepsItsMomentumAndItsAngle) {
  expect_spin(Device::kCuda);
}

TEST_F(MotionOnCard, ATumblingBoxFollowsEulersEquations) {
  expect_tumbling(Device::kCuda);
}

TEST_F(MotionOnCard, ASpinningPieceOfTwoIsNotTheOther) {
  expect_two_pieces(Device::kCuda);
}

TEST_F(MotionOnCard, ACantileverAndAPendulumSwingAsFineStepsSay) {
  expect_swing(Device::kCuda);
}

TEST_F(MotionOnCard, BarsKeepRinging) {
  expect_ringing(Device::kCuda);
}

#endif

}  // namespace
}  // namespace elastogen::test
