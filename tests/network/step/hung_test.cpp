// SPDX-License-Identifier: Apache-2.0
// The motion by `auto` of bodies that are held, and can turn or slide as a whole all the same.
#include "tests/network/step/hung_scenes.hpp"
#include "tests/network/step/motion_machines.hpp"

#include <algorithm>

namespace elastogen::test {
namespace {

void expect_hung_swing(Device device) {
  struct Case {
    const char* name;
    MovingScene m;
    double error, lost;  // of the centre over its way; energy over the largest kinetic energy
  };
  for (const Case& c : {Case{"edge", pendulum_on_cut_edge(1.2), 0.02, 0.03},
                        Case{"corner", block_on_a_corner(1), 0.02, 0.03}}) {
    ASSERT_FALSE(c.m.scene.dependent.empty());
    const std::vector<MotionFrame> run = play_on(device, c.m, kAuto, 60),
                                   fine = play(c.m, kSdirk2, 60, 16);
    // error over the diagonal of the box of the way
    double error = 0, kinetic = 0;
    Box way;
    for (size_t k = 0; k < run.size(); ++k) {
      const Vec3 a = mean_motion(c.m.scene, run[k].state).centre,
                 b = mean_motion(c.m.scene, fine[k].state).centre;
      error = std::max(error, safe_norm(minus(a, b)));
      way.add(b);
      kinetic = std::max(kinetic, fine[k].kinetic);
    }
    const double size = safe_norm(minus(way.upper, way.lower)),
                 change = run.back().energy - fine.front().energy;
    printf("swing on a cut %s: centre off by %.2f %% of its way, energy %+.2f %%, %.2f solves\n",
           c.name, 100 * error / size, 100 * change / kinetic, solves_a_frame(run));
    EXPECT_LT(error, c.error * size);
    EXPECT_LT(std::abs(change), c.lost * kinetic);
    EXPECT_LE(solves_a_frame(run), 2.5);
  }
}

/// Largest distance of nodes of thrown_box(true) from those of the whole at their places.
double distance_from_whole(const Scene& half, const State& part, const Scene& whole,
                           const State& all) {
  double off = 0;
  int64_t found = 0;
  const double middle = 3 * half.grid.h;  // x = 0 of the half in the whole
  for (int64_t n = 0; n < half.grid.node_count(); ++n)
    for (int64_t m = 0; m < whole.grid.node_count(); ++m) {
      double apart = 0, other = 0;
      for (int d = 0; d < 3; ++d) {
        const double shift = d == 0 ? middle : 0;
        apart += std::abs(half.grid.rest(n, d) + shift - whole.grid.rest(m, d));
        other += std::abs(part.x(n, d) + shift - all.x(m, d));
      }
      if (apart > 1e-9) continue;
      ++found;
      off = std::max(off, other);
    }
  EXPECT_EQ(found, half.grid.node_count());
  return off;
}

/// Momentum along the axes that are not held, and angular momentum about the one that is, are those of
/// a free body; the half moves as the whole.
void expect_half_flight(Device device) {
  const MovingScene whole = thrown_box(false), half = thrown_box(true);
  const Scene& scene = half.scene;
  const int frames = 30;
  const std::vector<MotionFrame> all = play_exactly(device, whole, kAuto, frames, 1e-7),
                                 part = play_exactly(device, half, kAuto, frames, 1e-7),
                                 loose = play_on(device, half, kAuto, frames);
  const double off = distance_from_whole(scene, part.back().state, whole.scene, all.back().state);
  printf("half of a box: off by %.1e m, %.2f solves a frame\n", off, solves_a_frame(loose));
  EXPECT_LT(off, 1e-6);
  // momentum, at the default tolerance too
  const double t = frames * kFrame;
  for (const std::vector<MotionFrame>* run : {&part, &loose}) {
    const MeanMotion before = mean_motion(scene, half.start),
                     after = mean_motion(scene, run->back().state);
    EXPECT_NEAR(after.velocity[1], 3 - 9.81 * t, 1e-11);
    EXPECT_NEAR(after.velocity[2], 1 + 2 * t, 1e-11);
    EXPECT_NEAR(after.spin[0], before.spin[0], 1e-12 * before.spin[0]);
    EXPECT_LE(solves_a_frame(*run), 1.4);
    for (int64_t n = 0; n < scene.grid.node_count(); ++n)
      if (scene.fixed(n, 0) >= 0) {
        EXPECT_EQ(run->back().state.v(n, 0), 0);
      }
  }
}

TEST(HungBody, OnACutEdgeOrCornerSwingsAsFineStepsSay) {
  expect_hung_swing(Device::kCpu);
}

TEST(HungBody, HeldAlongAnAxisFliesAsTheHalfOfAFreeOne) {
  expect_half_flight(Device::kCpu);
}

#ifdef ELASTOGEN_CUDA

TEST_F(MotionOnCard, BodiesOnACutEdgeOrCornerSwingAsFineStepsSay) {
  expect_hung_swing(Device::kCuda);
}

TEST_F(MotionOnCard, ABodyHeldAlongAnAxisFliesAsTheHalfOfAFreeOne) {
  expect_half_flight(Device::kCuda);
}

#endif

}  // namespace
}  // namespace elastogen::test
