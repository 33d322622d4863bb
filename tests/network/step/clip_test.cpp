// SPDX-License-Identifier: Apache-2.0
// Clips: begin, advance and read against step.
#include "core/error.hpp"
#include "network/solver.hpp"
#include "tests/network/device_support.hpp"

namespace elastogen::test {
namespace {

void expect_same(const State& a, const State& b) {
  EXPECT_EQ(a.x, b.x);
  EXPECT_EQ(a.v, b.v);
  EXPECT_EQ(a.x_before, b.x_before);
  EXPECT_EQ(a.v_before, b.v_before);
  EXPECT_EQ(a.time, b.time);
  EXPECT_EQ(a.steps, b.steps);
}

Scene small_beam(TimeScheme scheme) {
  Scene scene = clamped_beam(9, 2, 3, 0.02, solid(3e4, 0.4));
  scene.scheme = scheme;
  return scene;
}

/// A clip of some steps that is read at its end gives the bits of step().
void expect_clip_like_steps(const Scene& scene, const StartMotion& motion, Device device) {
  const SolverOptions options{.mode = SolverMode::kQuasi, .device = device};
  Solver one(scene, options), other(scene, options);
  State stepped = initial_state(scene, motion), read;
  other.begin(stepped);
  for (int k = 0; k < 6; ++k) {
    const StepReport a = one.step(stepped), b = other.advance();
    EXPECT_EQ(a.residual, b.residual);
    EXPECT_EQ(a.inner, b.inner);
    EXPECT_EQ(a.energy.kinetic, b.energy.kinetic);
    EXPECT_EQ(a.step, b.step);
  }
  State positions;
  other.read(positions, StateParts::kPositions);
  EXPECT_EQ(positions.x, stepped.x);
  EXPECT_TRUE(positions.v.empty());
  EXPECT_EQ(positions.time, stepped.time);
  other.read(read);
  expect_same(read, stepped);
}

/// A step that is given up on request leaves the clip where it was, and the next step is that of an
/// undisturbed clip.
void expect_interruption_to_leave_the_state(const Scene& scene, Device device) {
  int polls_left = 1 << 30;
  SolverOptions options{.mode = SolverMode::kQuasi, .device = device};
  options.interrupted = [&] { return --polls_left < 0; };
  Solver solver(scene, options), undisturbed(scene, {.mode = options.mode, .device = device});
  State state = initial_state(scene), before, after, expected;
  solver.begin(state);
  undisturbed.begin(state);
  // three steps, then one that is given up
  for (int k = 0; k < 3; ++k) solver.advance(), undisturbed.advance();
  solver.read(before);
  polls_left = 1;
  EXPECT_TRUE(solver.advance().interrupted);
  solver.read(after);
  expect_same(after, before);
  State stepped = before;
  polls_left = 1;
  EXPECT_TRUE(solver.step(stepped).interrupted);
  expect_same(stepped, before);
  // the next step is as if nothing had happened
  polls_left = 1 << 30;
  solver.begin(before);
  EXPECT_TRUE(solver.advance().converged);
  undisturbed.advance();
  solver.read(after);
  undisturbed.read(expected);
  expect_same(after, expected);
}

TEST(Clip, GivesTheBitsOfSteps) {
  expect_clip_like_steps(small_beam(TimeScheme::kEuler), {}, Device::kCpu);
  expect_clip_like_steps(small_beam(TimeScheme::kBdf2), {}, Device::kCpu);
}

TEST(Clip, StaysWhereItWasWhenInterrupted) {
  expect_interruption_to_leave_the_state(small_beam(TimeScheme::kBdf2), Device::kCpu);
}

TEST(Clip, GoesOnFromAStateReadBefore) {
  const Scene scene = small_beam(TimeScheme::kBdf2);
  const SolverOptions options{.mode = SolverMode::kQuasi};
  Solver whole(scene, options), resumed(scene, options);
  State middle, a, b;
  whole.begin(initial_state(scene));
  for (int k = 0; k < 3; ++k) whole.advance();
  whole.read(middle);
  resumed.begin(middle);
  for (int k = 0; k < 3; ++k) whole.advance(), resumed.advance();
  whole.read(a);
  resumed.read(b);
  expect_same(a, b);
}

TEST(Clip, MustBegin) {
  const Scene scene = small_beam(TimeScheme::kEuler);
  Solver solver(scene, {});
  State state = initial_state(scene);
  EXPECT_THROW(solver.advance(), Error);
  EXPECT_THROW(solver.read(state), Error);
  solver.begin(state);
  solver.step(state);  // which ends the clip
  EXPECT_THROW(solver.advance(), Error);
  state.v(0, 1) = NAN;
  EXPECT_THROW(solver.begin(state), Error);
}

#ifdef ELASTOGEN_CUDA

/// Three blocks, of which two fall on a floor that rises.
Scene blocks_on_floor() {
  Scene scene = three_blocks(TimeScheme::kBdf2);
  Collider floor = half_space({0, 1, 0}, -0.01, 0.4);
  floor.path = {{0, {}}, {1, {0, 0.1, 0}}};
  scene.colliders = {floor};
  scene.surface = face_points(scene.grid);
  return scene;
}

TEST_F(OnCard, ClipGivesTheBitsOfSteps) {
  expect_clip_like_steps(beam_of_regions(TimeScheme::kEuler), {}, Device::kCuda);
  expect_clip_like_steps(beam_of_regions(TimeScheme::kBdf2), {}, Device::kCuda);
  expect_clip_like_steps(three_blocks(TimeScheme::kBdf2),
                         {.velocity = {1, 2, 0}, .spin = {3, 1, 2}}, Device::kCuda);
  expect_clip_like_steps(blocks_on_floor(), {.velocity = {1, -2, 0}}, Device::kCuda);
}

TEST_F(OnCard, ClipStaysWhereItWasWhenInterrupted) {
  expect_interruption_to_leave_the_state(beam_of_regions(TimeScheme::kBdf2), Device::kCuda);
  expect_interruption_to_leave_the_state(three_blocks(TimeScheme::kEuler), Device::kCuda);
  expect_interruption_to_leave_the_state(blocks_on_floor(), Device::kCuda);
}

#endif

}  // namespace
}  // namespace elastogen::test
