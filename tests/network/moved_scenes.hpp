// SPDX-License-Identifier: Apache-2.0
// Soft bodies with ends that holders move, or under loads (core/holder.hpp, held_bodies.hpp).

#pragma once

#include "tests/network/held_bodies.hpp"

#include <cmath>

namespace elastogen::test {

inline constexpr TimeScheme kMovedSchemes[] = {TimeScheme::kEuler, TimeScheme::kBdf2,
                                               TimeScheme::kSdirk2, TimeScheme::kAuto};

/// A path that comes to rest at an offset within 9 steps of a sixtieth of a second.
inline Path eased_way(const Vec3& offset) {
  Path path{{0, {}}, {0.15, offset}};
  path.eases = true;
  return path;
}

/// swinging_bar() with its first end held by a holder, its second one by one at rest.
inline Scene moved_bar(TimeScheme scheme, double offset, Holder first) {
  Scene scene = swinging_bar(scheme, offset);
  scene.holders = {std::move(first), {}};
  scene.holder = Array<int32_t>(scene.grid.node_count());
  for (int64_t n = 0; n < scene.holder.rows(); ++n)
    scene.holder(n) = !scene.pinned(n) ? -1 : scene.grid.rest(n, 0) < 0.5 ? 0 : 1;
  finish_scene(scene);
  return scene;
}

/// Its first end is pulled along and across the bar, at a border that cuts voxels or fits the grid.
inline Scene pulled_bar(TimeScheme scheme, bool cut = true) {
  Holder pull;
  pull.path = eased_way({-0.04, 0.02, 0.01});
  return moved_bar(scheme, cut ? 0.7 : 0, std::move(pull));
}

/// Its first end turns about the axis of the bar.
inline Scene twisted_bar(TimeScheme scheme, bool cut) {
  Holder turn;
  turn.turns = true;
  turn.centre = {0.01, 0.1, 0.1};
  turn.path = eased_way({0.7, 0, 0});
  return moved_bar(scheme, cut ? 0.7 : 0, std::move(turn));
}

/// Loads that add an acceleration which differs from place to place.
inline void add_load(Scene& scene) {
  scene.load = Array<double>(scene.grid.node_count(), 3);
  for (int64_t n = 0; n < scene.load.rows(); ++n) {
    const Vec3 pull = {2, 1 - 3 * scene.grid.rest(n, 0), 4 * scene.grid.rest(n, 1)};
    for (int d = 0; d < 3; ++d) scene.load(n, d) = scene.mass(n) * pull[size_t(d)];
  }
  finish_scene(scene);
}

/// swinging_bar() with both ends held by one holder at rest, under a load.
inline Scene loaded_bar(TimeScheme scheme) {
  Scene scene = moved_bar(scheme, 0.7, {});
  add_load(scene);
  return scene;
}

/// The sum of the loads and of the weight of a body [N].
inline Vec3 force_on(const Scene& scene) {
  Vec3 sum = {};
  for (int64_t n = 0; n < scene.mass.rows(); ++n)
    for (int d = 0; d < 3; ++d)
      sum[size_t(d)] +=
          scene.mass(n) * scene.gravity[size_t(d)] + (scene.load.empty() ? 0 : scene.load(n, d));
  return sum;
}

inline Vec3 total_momentum(const Scene& scene, const State& state) {
  Vec3 sum = {};
  for (int64_t n = 0; n < scene.mass.rows(); ++n)
    for (int d = 0; d < 3; ++d) sum[size_t(d)] += scene.mass(n) * state.v(n, d);
  return sum;
}

/// The state has held nodes where holders put them at its time, to the rounding of positions, and
/// pinned ones with the velocities of these.
inline void expect_held(const Scene& scene, const State& state) {
  HeldNodes held(scene);
  held.set_time(state.time);
  std::vector<double> u(size_t(state.x.size()));
  for (size_t k = 0; k < u.size(); ++k) u[k] = state.x.data()[k] - scene.grid.rest.data()[k];
  std::vector<double> exact = u, v(state.v.data(), state.v.data() + u.size()), exact_v = v;
  held.place(exact.data());
  held.set_velocities(state.x.data(), exact_v.data());
  for (size_t k = 0; k < u.size(); ++k) {
    EXPECT_NEAR(u[k], exact[k], 1e-15);
    EXPECT_NEAR(v[k], exact_v[k], 1e-12);
  }
}

/// Steps of equal length, whatever their time error, each converged.
struct MovedRun {
  State state;
  std::vector<Reaction> reactions;  // at the end
  double moved = 0, loaded = 0;     // works of all steps [J], of schemes with a ledger
  double kinetic = 0, elastic = 0;  // at the end [J]
};

inline MovedRun run_moved(const Scene& scene, SolverMode mode, Device device, int steps) {
  SolverOptions options;
  options.mode = mode;
  options.device = device;
  options.tolerance = 1e-6;
  options.time_error = 1e3;
  options.follows_time_error = false;
  Solver solver(scene, options);
  EXPECT_EQ(solver.device() == "cpu", device == Device::kCpu);
  MovedRun run;
  run.state = initial_state(scene);
  for (int k = 0; k < steps; ++k) {
    const StepReport report = solver.step(run.state);
    EXPECT_TRUE(report.converged) << k << ": " << report.residual << ' ' << report.refusal;
    run.reactions = report.reactions;
    run.moved += report.ledger.done.moved;
    run.loaded += report.ledger.done.loaded;
    run.kinetic = report.energy.kinetic;
    run.elastic = report.energy.elastic;
  }
  return run;
}

}  // namespace elastogen::test
