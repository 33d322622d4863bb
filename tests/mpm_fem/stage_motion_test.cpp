// SPDX-License-Identifier: Apache-2.0
// Motion by stages of finite elements against closed forms, fine steps and the network.
#include "core/error.hpp"
#include "tests/mpm_fem/stage_scenes.hpp"
#include "tests/network/step/hung_scenes.hpp"

#include <numbers>

namespace elastogen::test {
namespace {

using fem::FemScene;
using fem::FemState;
using fem::Scheme;

/// The scene on hexahedra with a consistent mass.
FemScene consistent(const Scene& scene) {
  FemScene result = as_fem(scene);
  result.mesh = fem::voxel_mesh(scene, fem::Element::kHex);
  result.mass = {};
  result.mass_kind = fem::Mass::kConsistent;
  return result;
}

/// Linear momentum and angular momentum about the origin, by the mass matrix.
std::array<double, 6> momentum(const FemScene& scene, const FemState& state) {
  FemScene euler = scene;
  euler.scheme = Scheme::kEuler;
  const fem::ImplicitFem integrator(euler);
  Array<double> Mv(state.v.rows(), 3);
  integrator.potential().mass().multiply(state.v.data(), Mv.data());
  std::array<double, 6> sum = {};
  for (int64_t n = 0; n < Mv.rows(); ++n)
    for (int d = 0; d < 3; ++d) {
      const int a = (d + 1) % 3, b = (d + 2) % 3;
      const double xa = scene.mesh.rest(n, a) + state.u(n, a),
                   xb = scene.mesh.rest(n, b) + state.u(n, b);
      sum[size_t(d)] += Mv(n, d);
      sum[size_t(3 + d)] += xa * Mv(n, b) - xb * Mv(n, a);
    }
  return sum;
}

TEST(StageMotion, NetworkAndFiniteElementsAgreeOverARunByTheTimeError) {
  // two programs, one potential: the same steps, and nodes that differ by rounding and tolerance
  struct Case {
    const char* name;
    MovingScene m;
    int frames;
  };
  const double degree = std::numbers::pi / 180;
  for (const Case& c :
       {Case{"pendulum", small_pendulum(1.2), 30}, Case{"ball that hops", small_ball(1e6, 1), 10},
        Case{"block on a slope", small_block(20 * degree), 15},
        Case{"block that slides", small_block(45 * degree), 8},
        Case{"pendulum on a cut edge", pendulum_on_cut_edge(1.2, 0.1, 25), 20},
        Case{"block on a cut corner", block_on_a_corner(1, 0.1, 25), 12},
        Case{"half of a box in flight", thrown_box(true), 12}}) {
    const std::vector<MotionFrame> run = play(c.m, Scheme::kAuto, c.frames, 1, 1e-8);
    const std::vector<MotionFrame> network =
        play(c.m, TimeScheme::kAuto, c.frames, 1,
             {.mode = SolverMode::kNewton, .tolerance = 1e-8, .follows_time_error = false});
    double off = 0;
    int steps = 0;
    ASSERT_EQ(run.size(), network.size());
    for (size_t k = 0; k < run.size(); ++k) {
      EXPECT_EQ(run[k].steps, network[k].steps) << c.name << ", frame " << k;
      EXPECT_EQ(run[k].solves, network[k].solves) << c.name << ", frame " << k;
      off = std::max(off, rms_distance(c.m.scene, run[k].state.x, network[k].state.x));
      steps += run[k].steps;
    }
    printf("%s: %d steps, off by %.1e m\n", c.name, steps, off);
    EXPECT_LT(off, 1e-9) << c.name;
  }
}

TEST(StageMotion, FreeFallUnderALoadIsExact) {
  // gravity and a dead load that pulls all nodes evenly, at either mass, and where nodes are held
  // in a plane
  Scene grid = scene_on(make_box(2, 3, 2, 0.1), solid(1e5, 0.3));
  grid.gravity = {0, -9.81, 0};
  finish_scene(grid);
  FemScene plane = as_fem(grid);
  for (int64_t n = 0; n < plane.fixed.rows(); ++n) plane.fixed(n, 2) = 1;
  for (FemScene scene : {as_fem(grid), consistent(grid), plane}) {
    const double mass = 12, pull = 2;  // kg, m/s^2
    scene.force = [&](double, Out<double> force) {
      for (int64_t n = 0; n < force.rows; ++n) force(n, 0) = pull * grid.mass(n);
    };
    for (const Scheme scheme : {Scheme::kSdirk2, Scheme::kAuto}) {
      FemState state = fem::rest_state(scene);
      for (int64_t n = 0; n < state.v.rows(); ++n) state.v(n, 1) = 3;
      play(scene, state, scheme, 6, 1, 1e-10);
      const double t = 6 * kFrame;
      const std::array<double, 6> P = momentum(scene, state);
      EXPECT_NEAR(P[0], mass * pull * t, 1e-11);
      EXPECT_NEAR(P[1], mass * (3 - 9.81 * t), 1e-11);
      EXPECT_NEAR(state.u(0, 1), 3 * t - 9.81 * t * t / 2, 1e-9);
      EXPECT_NEAR(state.u(0, 0), pull * t * t / 2, 1e-9);
    }
  }
}

TEST(StageMotion, ASpinKeepsItsMomentumAndItsAngle) {
  // 30 frames at 10 rad/s: 10 rad
  Scene grid = scene_on(ball_grid(0.2, 0.1), solid(young_of_frame(50, 0.1), 0.4));
  finish_scene(grid);
  const State start = initial_state(grid, {.velocity = {0.3, 0, 0}, .spin = {0, 0, 10}});
  for (const FemScene& scene : {as_fem(grid), consistent(grid)}) {
    FemState state = as_fem(scene, start);
    const std::array<double, 6> before = momentum(scene, state);
    const std::vector<MotionFrame> run = play(scene, state, Scheme::kAuto, 30);
    const std::array<double, 6> after = momentum(scene, state);
    for (size_t d = 0; d < 6; ++d) EXPECT_NEAR(after[d], before[d], 1e-12 * before[5]);
    // the angle of a chord
    const int64_t a = 0, b = state.u.rows() - 1;
    const auto chord = [&](bool rest, int d) {
      return scene.mesh.rest(b, d) - scene.mesh.rest(a, d) +
             (rest ? 0 : state.u(b, d) - state.u(a, d));
    };
    const double X = chord(true, 0), Y = chord(true, 1), x = chord(false, 0), y = chord(false, 1);
    const double angle = std::atan2(X * y - Y * x, X * x + Y * y) + 4 * std::numbers::pi;
    printf("spin: %.5f rad of 10, %.2f solves a frame\n", angle, solves_a_frame(run));
    EXPECT_NEAR(angle, 10, 5e-3);
    EXPECT_LE(solves_a_frame(run), 1.1);
  }
}

TEST(StageMotion, APieceThatSpinsDoesNotMoveAnother) {
  // two blocks that do not touch; the other one is pinned
  std::vector<int32_t> at;
  for (const int first : {0, 10})
    for (int x = 0; x < 2; ++x)
      for (int y = 0; y < 2; ++y) at.insert(at.end(), {first + x, y, 0});
  Array<int32_t> list(int64_t(at.size()) / 3, 3);
  std::copy(at.begin(), at.end(), list.data());
  const double h = 0.05;
  Scene grid = scene_on(make_grid(list, h, {}), solid(young_of_frame(20, h), 0.3));
  for (int64_t n = 0; n < grid.grid.node_count(); ++n)
    grid.pinned(n) = grid.grid.rest(n, 0) > 11.5 * h;
  finish_scene(grid);
  const FemScene scene = as_fem(grid);
  FemState state = fem::rest_state(scene);
  for (int64_t n = 0; n < state.v.rows(); ++n)
    if (scene.mesh.rest(n, 0) < 5 * h) {
      state.v(n, 0) = -8 * (scene.mesh.rest(n, 1) - h);
      state.v(n, 1) = 8 * (scene.mesh.rest(n, 0) - h);
    }
  const double before = momentum(scene, state)[5];
  play(scene, state, Scheme::kAuto, 12);
  EXPECT_NEAR(momentum(scene, state)[5], before, 1e-12 * before);
  double moved = 0;
  for (int64_t n = 0; n < state.u.rows(); ++n)
    for (int d = 0; d < 3; ++d)
      if (scene.mesh.rest(n, 0) > 5 * h) moved = std::max(moved, std::abs(state.u(n, d)));
  EXPECT_EQ(moved, 0);
}

TEST(StageMotion, APendulumSwingsAsFineStepsSay) {
  // at pinned nodes, and on an edge that is cut out of voxels
  for (const MovingScene& m : {small_pendulum(1.2), pendulum_on_cut_edge(1.2, 0.1, 25)}) {
    const std::vector<MotionFrame> run = play(m, Scheme::kAuto, 30),
                                   fine = play(m, Scheme::kSdirk2, 30, 16);
    double error = 0, low = 1e300, high = -1e300;
    for (size_t k = 0; k < run.size(); ++k) {
      const Vec3 a = mean_motion(m.scene, run[k].state).centre,
                 b = mean_motion(m.scene, fine[k].state).centre;
      error = std::max(error, safe_norm(minus(a, b)));
      low = std::min(low, b[0]), high = std::max(high, b[0]);
    }
    printf("pendulum: centre off by %.2f %% of its range, %.2f solves a frame\n",
           100 * error / (high - low), solves_a_frame(run));
    EXPECT_LT(error, 0.02 * (high - low));
    EXPECT_LE(solves_a_frame(run), 2.5);
  }
}

TEST(StageMotion, ABarRingsOnAsItsEquationSays) {
  // one row of voxels with nu = 0, which vibrates with a period of 16 frames
  const int count = 16;
  const double h = 0.05, L = count * h, c = 2 * L / (16 * kFrame);
  Scene grid = scene_on(make_box(count, 1, 1, h), solid(1000 * c * c, 0));
  finish_scene(grid);
  const FemScene scene = as_fem(grid);
  FemState state = fem::rest_state(scene);
  const double omega = 2 * std::numbers::pi / (16 * kFrame), amplitude = 0.01 * L;
  const auto mode = [&](int64_t n) {
    return std::cos(std::numbers::pi * grid.grid.rest(n, 0) / L);
  };
  for (int64_t n = 0; n < state.v.rows(); ++n) state.v(n, 0) = amplitude * omega * mode(n);
  const std::vector<MotionFrame> run = play(scene, state, Scheme::kAuto, 60);
  // amplitude of the mode over the last period, period from its zeros
  double norm = 0, last = 0, before = 0;
  std::vector<double> zeros;
  for (int64_t n = 0; n < state.v.rows(); ++n) norm += grid.mass(n) * mode(n) * mode(n);
  for (size_t k = 0; k < run.size(); ++k) {
    double q = 0;
    for (int64_t n = 0; n < state.v.rows(); ++n)
      q += grid.mass(n) * mode(n) * (run[k].state.x(n, 0) - grid.grid.rest(n, 0)) / norm;
    if (k > 0 && (q > 0) != (before > 0)) zeros.push_back(double(k) - q / (q - before));
    if (k + 16 >= run.size()) last = std::max(last, std::abs(q));
    before = q;
  }
  const double period = 2 * (zeros.back() - zeros.front()) / double(zeros.size() - 1);
  printf("bar: amplitude %.3f, period %.3f frames of 16, %.2f solves a frame\n", last / amplitude,
         period, solves_a_frame(run));
  EXPECT_GT(last, 0.92 * amplitude);
  EXPECT_LT(last, 1.02 * amplitude);
  EXPECT_NEAR(period, 16, 0.025 * 16);
  EXPECT_LE(solves_a_frame(run), 2.3);
}

/// Order in dt of SDIRK2, from displacements at a time by 16 and 32 steps a frame against 128.
double order_of(const FemScene& scene, const FemState& start, int frames) {
  Array<double> u[3];
  constexpr int kParts[3] = {16, 32, 128};
  for (int k = 0; k < 3; ++k) {
    FemState state = start;
    play(scene, state, Scheme::kSdirk2, frames, kParts[k], 1e-8);
    u[k] = state.u;
  }
  double square[2] = {};
  for (int k = 0; k < 2; ++k)
    for (int64_t i = 0; i < u[k].size(); ++i)
      square[k] += std::pow(u[k].data()[i] - u[2].data()[i], 2);
  // the run with 128 steps has an error of its own, 1/16 and 1/64 of those of the others
  return std::log2(std::sqrt(square[0] / square[1]) * (1 - 1.0 / 16) / (1 - 1.0 / 64));
}

TEST(StageMotion, Sdirk2HasOrder2) {
  // a bar that spins and vibrates, and a pendulum, both soft enough to be resolved
  Scene bar = scene_on(make_box(4, 1, 1, 0.1), solid(2e4, 0.3));
  finish_scene(bar);
  const FemScene free = consistent(bar);
  FemState start = as_fem(free, initial_state(bar, {.spin = {0, 1, 6}}));
  for (int64_t n = 0; n < start.v.rows(); ++n)
    start.v(n, 0) += 0.3 * std::cos(std::numbers::pi * bar.grid.rest(n, 0) / 0.4);
  const double of_bar = order_of(free, start, 4);
  const MovingScene pendulum = small_pendulum(0.8);
  FemScene soft = as_fem(pendulum.scene);
  soft.materials[0].young = 5e4;
  const double of_pendulum = order_of(soft, fem::rest_state(soft), 4);
  printf("order: bar %.2f, pendulum %.2f\n", of_bar, of_pendulum);
  EXPECT_NEAR(of_bar, 2, 0.2);
  EXPECT_NEAR(of_pendulum, 2, 0.2);
}

TEST(StageMotion, APrescribedMotionHasOrder2) {
  // a bar whose end is moved along it, by either mass
  Scene bar = scene_on(make_box(4, 1, 1, 0.1), solid(2e4, 0.3));
  finish_scene(bar);
  for (FemScene scene : {as_fem(bar), consistent(bar)}) {
    for (int64_t n = 0; n < bar.grid.node_count(); ++n)
      if (bar.grid.rest(n, 0) == 0) std::fill_n(scene.fixed.row(n), 3, uint8_t(1));
    scene.motion = [&](double time, Out<double> u) {
      for (int64_t n = 0; n < u.rows; ++n) {
        u(n, 0) = 0.02 * (1 - std::cos(20 * time));
        u(n, 1) = u(n, 2) = 0;
      }
    };
    const double order = order_of(scene, fem::rest_state(scene), 4);
    printf("order with a moved end: %.2f\n", order);
    EXPECT_NEAR(order, 2, 0.2);
  }
}

}  // namespace
}  // namespace elastogen::test
