// SPDX-License-Identifier: Apache-2.0
// Bodies held along some axes only.
#include "core/error.hpp"
#include "tests/network/fixed_scenes.hpp"

#include <gtest/gtest.h>

namespace elastogen::test {
namespace {

Vec3 node_at(const Array<double>& places, int64_t n) {
  return {places(n, 0), places(n, 1), places(n, 2)};
}

/// A force along x on the face at a place, spread by area.
void load_face(Scene& scene, double place, double force) {
  scene.load = Array<double>(scene.grid.node_count(), 3);
  double all = 0;
  for (int64_t n = 0; n < scene.load.rows(); ++n) {
    int faces = 0;
    for (int c = 0; c < 8; ++c) faces += scene.grid.voxels(n, c) >= 0;
    if (std::abs(scene.grid.rest(n, 0) - place) < 1e-9) scene.load(n, 0) = faces;
    all += scene.load(n, 0);
  }
  for (int64_t n = 0; n < scene.load.rows(); ++n) scene.load(n, 0) *= force / all;
  finish_scene(scene);
}

TEST(FixedAxes, LetABarStretchAndNarrowEvenly) {
  constexpr double kYoung = 1e8, kPoisson = 0.3, kStretch = 1.3;
  Scene scene = held_scene(box_surface({0, 0, 0}, {0.4, 0.2, 0.2}), {}, 0.05, {});
  scene.materials[0].law = Law::kStvk;
  scene.gravity = {};
  for (int axis = 0; axis < 3; ++axis) fix_plane(scene, axis, 0);
  // StVK: with Green's strains e and -nu e, the force over the area at rest is s E e
  const double strain = (kStretch * kStretch - 1) / 2, force = kStretch * kYoung * strain * 0.04,
               narrow = std::sqrt(1 - 2 * kPoisson * strain);
  load_face(scene, 0.4, force);
  StepReport report;
  const State state = equilibrium(scene, &report);
  for (int64_t n = 0; n < state.x.rows(); ++n)
    for (int d = 0; d < 3; ++d)
      EXPECT_NEAR(state.x(n, d), (d == 0 ? kStretch : narrow) * scene.grid.rest(n, d), 1e-7);
  // the first holder bears the force
  ASSERT_EQ(report.reactions.size(), 3u);
  for (size_t h = 0; h < 3; ++h)
    for (size_t d = 0; d < 3; ++d)
      EXPECT_NEAR(report.reactions[h].force[d], h == 0 && d == 0 ? -force : 0, 1e-6 * force);
}

TEST(FixedAxes, InAPlaneOfSymmetryMakeAHalfMoveAsTheWhole) {
  for (const TimeScheme scheme : kMovedSchemes)
    for (const SolverMode mode : {SolverMode::kNewton, SolverMode::kQuasi}) {
      SCOPED_TRACE(concat(int(scheme), ' ', int(mode)));
      const Scene whole = symmetric_bar(scheme, false), half = symmetric_bar(scheme, true);
      const State all = run_moved(whole, mode, Device::kCpu, 12).state;
      const State part = run_moved(half, mode, Device::kCpu, 12).state;
      double most = 0, off = 0;
      int found = 0;
      for (int64_t n = 0; n < half.grid.node_count(); ++n)
        for (int64_t m = 0; m < whole.grid.node_count(); ++m) {
          const Vec3 X = node_at(half.grid.rest, n), Y = node_at(whole.grid.rest, m);
          if (safe_norm(minus(X, Y)) > 1e-9) continue;
          ++found;
          most = std::max(most, safe_norm(minus(node_at(all.x, m), Y)));
          off = std::max(off, safe_norm(minus(node_at(part.x, n), node_at(all.x, m))));
        }
      EXPECT_EQ(found, half.grid.node_count());
      EXPECT_GT(most, 0.05);
      EXPECT_LT(off, 1e-5 * most);
    }
}

TEST(FixedAxes, BearTheWeightOfABodyThatFallsAlongThem) {
  for (const TimeScheme scheme : kMovedSchemes) {
    SCOPED_TRACE(int(scheme));
    Scene scene = symmetric_bar(scheme, true);
    for (int64_t n = 0; n < scene.pinned.rows(); ++n) scene.pinned(n) = kFreeNode;
    scene.fixed = {};
    scene.holders = {};
    scene.gravity = {1, -2, 0};
    fix(scene, 1, [](const Vec3&) { return true; });
    const MovedRun run = run_moved(scene, SolverMode::kNewton, Device::kCpu, 10);
    const double mass = 1000 * 0.5 * 0.04, t = 10 * scene.dt;
    for (int64_t n = 0; n < run.state.x.rows(); ++n) {
      EXPECT_EQ(run.state.x(n, 1), scene.grid.rest(n, 1));
      EXPECT_EQ(run.state.v(n, 1), 0);
    }
    EXPECT_NEAR(total_momentum(scene, run.state)[0], mass * t, 1e-6 * mass * t);
    EXPECT_NEAR(run.reactions[0].force[1], 2 * mass, 1e-5 * mass);
    EXPECT_EQ(run.reactions[0].force[0], 0);
  }
}

TEST(FixedAxes, AndBordersTogetherBearWeightAndInertia) {
  // long steps of Euler are statics
  Scene scene = on_rails(moved_bar(TimeScheme::kEuler, 0.7, {}));
  scene.materials[0] = solid(1e7, 0.3);
  scene.dt = 100;
  finish_scene(scene);
  StepReport report;
  const State state = equilibrium(scene, &report);
  Vec3 sum = force_on(scene);
  for (const Reaction& reaction : report.reactions) sum = plus(sum, reaction.force);
  const double weight = safe_norm(force_on(scene));
  EXPECT_LT(safe_norm(sum), 1e-6 * weight);
  EXPECT_GT(std::abs(report.reactions[2].force[2]), 0.5 * std::abs(force_on(scene)[2]));
  // dependent nodes that follow the plane bring a part of it
  HeldNodes held(scene);
  int parents = 0;
  for (const HeldNode& node : held.nodes()[2]) parents += node.parent >= 0;
  EXPECT_GT(parents, 3);
  expect_held(scene, state);
}

TEST(FixedAxes, RefuseWhatIsHeldAlready) {
  Scene scene = symmetric_bar(TimeScheme::kEuler, true);
  for (int64_t n = 0; n < scene.pinned.rows(); ++n)
    if (scene.pinned(n)) scene.fixed(n, 1) = 0;
  EXPECT_THROW(finish_scene(scene), Error);
  scene = symmetric_bar(TimeScheme::kEuler, true);
  scene.fixed(0, 0) = 7;
  EXPECT_THROW(finish_scene(scene), Error);
  SolverOptions paper;
  paper.mode = SolverMode::kPaper;
  EXPECT_THROW(Solver(symmetric_bar(TimeScheme::kEuler, true), paper), Error);
}

}  // namespace
}  // namespace elastogen::test
