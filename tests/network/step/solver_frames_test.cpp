// SPDX-License-Identifier: Apache-2.0
// Frames of a clip against deform_asset and deformation_gradient of the state they were made of, to
// the bit, on the CPU and on the card.
#include "core/error.hpp"
#include "network/solver.hpp"
#include "tests/network/device_support.hpp"
#include "voxelize/embedding.hpp"

#include <cstring>
#include <future>

#ifdef ELASTOGEN_CUDA
#include "tests/network/device_memory.hpp"
#endif

namespace elastogen::test {
namespace {

constexpr StartMotion kSpinning = {.velocity = {0.5, 1, 0}, .spin = {2, 3, -1}};

/// Points in and around the voxels of a scene: in full ones, border ones and up to 4 h outside.
Array<double> points_around(const Scene& scene, int64_t count) {
  Box box;
  for (int64_t n = 0; n < scene.grid.node_count(); ++n)
    box.add({scene.grid.rest(n, 0), scene.grid.rest(n, 1), scene.grid.rest(n, 2)});
  std::mt19937 random(3);
  const double margin = 4 * scene.grid.h;
  Array<double> points(count, 3);
  for (int64_t p = 0; p < count; ++p)
    for (int d = 0; d < 3; ++d) {
      const size_t axis = size_t(d);
      std::uniform_real_distribution<double> place(box.lower[axis] - margin,
                                                   box.upper[axis] + margin);
      points(p, d) = place(random);
    }
  return points;
}

/// A frame of the state x, by the CPU's loops.
struct Expected {
  Expected(const Scene& scene, const Embedding& embedding, const Array<double>& x)
      : displacement(embedding.voxel.rows(), 3), gradient(embedding.voxel.rows(), 9) {
    deform_asset(scene.grid, embedding, x, displacement);
    deformation_gradient(scene.grid, embedding, x, gradient);
  }
  Array<double> displacement, gradient;
};

bool same_bits(const double* found, const Array<double>& expected) {
  return std::memcmp(found, expected.data(), size_t(expected.size()) * sizeof(double)) == 0;
}

double largest_of(const Array<double>& values) {
  double largest = 0;
  for (int64_t k = 0; k < values.size(); ++k)
    largest = std::max(largest, std::abs(values.data()[k]));
  return largest;
}

/// A clip of a spinning body with points that it carries.
struct CarryingClip {
  CarryingClip(const Scene& s, Device device, bool with_gradient, int64_t points = 3000)
      : scene(s),
        solver(s, {.mode = SolverMode::kQuasi, .device = device}),
        embedding(embed(s.grid, points_around(s, points))) {
    solver.begin(initial_state(s, kSpinning));
    solver.carry(embedding, with_gradient);
  }
  Expected expected() const {
    State state;
    solver.read(state, StateParts::kPositions);
    return {scene, embedding, state.x};
  }

  const Scene& scene;
  Solver solver;
  Embedding embedding;
};

/// Each frame is taken after the step that follows its start.
void expect_frames_of_their_states(const Scene& scene, Device device, bool with_gradient) {
  CarryingClip clip(scene, device, with_gradient);
  for (int64_t k = 0; k < 6; ++k) {
    const int64_t number = clip.solver.start_frame();
    EXPECT_EQ(number, k);
    const Expected expected = clip.expected();
    EXPECT_TRUE(clip.solver.advance().finite);
    const CarriedFrame frame = clip.solver.take_frame(number);
    EXPECT_TRUE(same_bits(frame.displacement, expected.displacement));
    ASSERT_EQ(frame.gradient != nullptr, with_gradient);
    EXPECT_TRUE(!with_gradient || same_bits(frame.gradient, expected.gradient));
    EXPECT_EQ(largest_of(expected.displacement) > 0, k > 0);
  }
}

/// Two frames in flight, taken in either order; another thread takes one beside a step.
void expect_two_frames_at_a_time(const Scene& scene, Device device) {
  CarryingClip clip(scene, device, true);
  for (int k = 0; k < 4; ++k) {
    const int64_t a = clip.solver.start_frame();
    const Expected of_a = clip.expected();
    clip.solver.advance();
    const int64_t b = clip.solver.start_frame();
    const Expected of_b = clip.expected();
    auto other = std::async(std::launch::async, [&] {
      const CarriedFrame frame = clip.solver.take_frame(b);
      return same_bits(frame.displacement, of_b.displacement) &&
             same_bits(frame.gradient, of_b.gradient);
    });
    clip.solver.advance();
    EXPECT_TRUE(other.get());
    EXPECT_TRUE(same_bits(clip.solver.take_frame(a).displacement, of_a.displacement));
    EXPECT_TRUE(same_bits(clip.solver.take_frame(a).gradient, of_a.gradient));
    EXPECT_TRUE(same_bits(clip.solver.take_frame(b).gradient, of_b.gradient));
  }
}

/// The largest component of the positions that are read.
void expect_reach_of_the_state(const Scene& scene, Device device) {
  Solver solver(scene, {.mode = SolverMode::kQuasi, .device = device});
  State state = initial_state(scene, kSpinning);
  State torn = state;
  torn.x(2, 1) = -7.25;
  solver.begin(torn);
  EXPECT_EQ(solver.reach(), 7.25);
  solver.begin(state);
  for (int k = 0; k < 3; ++k) {
    EXPECT_TRUE(solver.advance().finite);
    solver.read(state, StateParts::kPositions);
    EXPECT_EQ(solver.reach(), largest_of(state.x));
  }
}

void expect_refusals(const Scene& scene, Device device) {
  Solver solver(scene, {.mode = SolverMode::kQuasi, .device = device});
  EXPECT_THROW(solver.reach(), Error);
  EXPECT_THROW(solver.start_frame(), Error);
  solver.begin(initial_state(scene));
  EXPECT_THROW(solver.start_frame(), Error);
  Embedding embedding = embed(scene.grid, points_around(scene, 5));
  embedding.voxel(4) = int32_t(scene.grid.voxel_count());
  EXPECT_THROW(solver.carry(embedding, false), Error);
  embedding.voxel(4) = 0;
  embedding.weights = Array<double>(4, 8);
  EXPECT_THROW(solver.carry(embedding, false), Error);
  embedding = embed(scene.grid, Array<double>(0, 3));
  solver.carry(embedding, true);  // no points: frames without numbers
  EXPECT_THROW(solver.take_frame(0), Error);
  for (int k = 0; k < 3; ++k) solver.take_frame(solver.start_frame());
  EXPECT_THROW(solver.take_frame(-1), Error);
  EXPECT_THROW(solver.take_frame(0), Error);  // gone
  EXPECT_NO_THROW(solver.take_frame(1));
  EXPECT_THROW(solver.take_frame(3), Error);
}

TEST(Frames, AreThoseOfTheirStates) {
  expect_frames_of_their_states(falling_bar(TimeScheme::kEuler), Device::kCpu, true);
  expect_frames_of_their_states(falling_bar(TimeScheme::kBdf2), Device::kCpu, false);
}

TEST(Frames, TwoAreThereAtATime) {
  expect_two_frames_at_a_time(falling_bar(TimeScheme::kBdf2), Device::kCpu);
}

TEST(Frames, ReachIsTheLargestComponent) {
  expect_reach_of_the_state(falling_bar(TimeScheme::kBdf2), Device::kCpu);
}

TEST(Frames, RefuseWhatIsNotThere) {
  expect_refusals(falling_bar(TimeScheme::kEuler), Device::kCpu);
}

#ifdef ELASTOGEN_CUDA

TEST_F(OnCard, FramesAreThoseOfTheirStates) {
  for (const bool with_gradient : {false, true}) {
    expect_frames_of_their_states(falling_bar(TimeScheme::kEuler), Device::kCuda, with_gradient);
    expect_frames_of_their_states(three_blocks(TimeScheme::kBdf2), Device::kCuda, with_gradient);
  }
}

TEST_F(OnCard, FramesAreThereTwoAtATime) {
  expect_two_frames_at_a_time(falling_bar(TimeScheme::kBdf2), Device::kCuda);
  expect_two_frames_at_a_time(three_blocks(TimeScheme::kEuler), Device::kCuda);
}

TEST_F(OnCard, FramesMayStartAnewWithOtherPoints) {
  const Scene scene = falling_bar(TimeScheme::kEuler);
  CarryingClip clip(scene, Device::kCuda, false);
  clip.solver.start_frame();  // and is on its way
  const Embedding others = embed(scene.grid, points_around(scene, 20000));
  clip.solver.carry(others, true);
  clip.solver.advance();
  const int64_t number = clip.solver.start_frame();
  EXPECT_EQ(number, 0);
  State state;
  clip.solver.read(state);
  const Expected expected(scene, others, state.x);
  const CarriedFrame frame = clip.solver.take_frame(number);
  EXPECT_TRUE(same_bits(frame.displacement, expected.displacement));
  EXPECT_TRUE(same_bits(frame.gradient, expected.gradient));
}

TEST_F(OnCard, FramesAreMadeOnTheHostWhereTheCardHasNoRoom) {
  const Scene scene = falling_bar(TimeScheme::kEuler);
  CarryingClip clip(scene, Device::kCuda, false, 1);
  const Embedding many = embed(scene.grid, points_around(scene, 100000));
  {
    const AllMemory taken;
    clip.solver.carry(many, true);
  }
  clip.solver.advance();
  const int64_t number = clip.solver.start_frame();
  State state;
  clip.solver.read(state);
  clip.solver.advance();
  const Expected expected(scene, many, state.x);
  EXPECT_TRUE(same_bits(clip.solver.take_frame(number).displacement, expected.displacement));
  EXPECT_TRUE(same_bits(clip.solver.take_frame(number).gradient, expected.gradient));
}

TEST_F(OnCard, ReachIsTheLargestComponent) {
  expect_reach_of_the_state(falling_bar(TimeScheme::kBdf2), Device::kCuda);
  expect_reach_of_the_state(three_blocks(TimeScheme::kEuler), Device::kCuda);
}

TEST_F(OnCard, FramesRefuseWhatIsNotThere) {
  expect_refusals(falling_bar(TimeScheme::kEuler), Device::kCuda);
}

#endif

}  // namespace
}  // namespace elastogen::test
