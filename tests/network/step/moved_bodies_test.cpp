// SPDX-License-Identifier: Apache-2.0
// Steps of bodies with ends that move, or under loads, on the CPU.
#include "core/error.hpp"
#include "tests/network/moved_scenes.hpp"

namespace elastogen::test {
namespace {

TEST(MovedBodies, EndsAreWhereHoldersPutThem) {
  for (const TimeScheme scheme : kMovedSchemes)
    for (const SolverMode mode : {SolverMode::kQuasi, SolverMode::kNewton})
      for (const bool cut : {false, true})
        for (const Scene& scene : {pulled_bar(scheme, cut), twisted_bar(scheme, cut)}) {
          SCOPED_TRACE(concat(scheme_name(scheme), ", cut ", cut));
          expect_held(scene, run_moved(scene, mode, Device::kCpu, 6).state);
        }
}

TEST(MovedBodies, AFreeBodyUnderALoadTakesUpItsImpulse) {
  for (const TimeScheme scheme : kMovedSchemes) {
    SCOPED_TRACE(scheme_name(scheme));
    Scene scene = scene_on(make_box(8, 3, 3, 0.05), solid(2e5, 0.3));
    scene.gravity = {0, -9.81, 0};
    scene.scheme = scheme;
    finish_scene(scene);
    add_load(scene);
    const MovedRun run = run_moved(scene, SolverMode::kNewton, Device::kCpu, 6);
    const Vec3 gained = total_momentum(scene, run.state), force = force_on(scene);
    for (size_t d = 0; d < 3; ++d)
      EXPECT_NEAR(gained[d], run.state.time * force[d], 1e-12 * safe_norm(force));
  }
}

/// The reaction of a holder to forces r without weight, by its definition.
Reaction defined_reaction(const Scene& scene, int holder, const std::vector<double>& r,
                          const std::vector<double>& u) {
  const auto at = [](const std::vector<double>& of, int64_t n) {
    return Vec3{of[size_t(3 * n)], of[size_t(3 * n + 1)], of[size_t(3 * n + 2)]};
  };
  const auto place = [&](int64_t n) {
    const double* X = scene.grid.rest.row(n);
    return plus({X[0], X[1], X[2]}, at(u, n));
  };
  // the point of moments, then what pinned nodes and dependent ones add
  Reaction sum{{}, {}, scene.holders[size_t(holder)].centre};
  double count = 0;
  Vec3 mean = {};
  for (int64_t n = 0; n < scene.holder.rows(); ++n)
    if (scene.holder(n) == holder) mean = plus(mean, place(n)), ++count;
  if (!scene.holders[size_t(holder)].turns) sum.about = scaled(mean, 1 / count);
  const auto add = [&](const Vec3& arm, double share, const Vec3& force) {
    sum.force = plus(sum.force, scaled(force, share));
    sum.moment = plus(sum.moment, cross(arm, force));
  };
  for (int64_t n = 0; n < scene.holder.rows(); ++n)
    if (scene.holder(n) == holder && scene.pinned(n) == kPinnedNode)
      add(minus(place(n), sum.about), 1,
          minus(at(r, n), {scene.load(n, 0), scene.load(n, 1), scene.load(n, 2)}));
  for (int64_t i = 0; i < scene.dependent.count(); ++i) {
    const int64_t n = scene.dependent.node(i);
    if (scene.holder(n) != holder) continue;
    Vec3 arm = minus(place(n), sum.about);
    double share = 1;
    for (int64_t k = 0; k < scene.dependent.parents(i).rows; ++k) {
      const double w = scene.dependent.weights(i)(k);
      arm = minus(arm, scaled(minus(place(scene.dependent.parents(i)(k)), sum.about), w));
      share -= w;
    }
    add(arm, share, at(r, n));
  }
  return sum;
}

TEST(MovedBodies, ReactionsAreThoseOfTheirDefinition) {
  for (const bool cut : {false, true})
    for (Scene scene :
         {pulled_bar(TimeScheme::kEuler, cut), twisted_bar(TimeScheme::kEuler, cut)}) {
      scene.gravity = {};
      add_load(scene);
      std::vector<double> r(3 * size_t(scene.grid.node_count())), u = r;
      for (size_t k = 0; k < r.size(); ++k)
        r[k] = std::sin(double(k)), u[k] = 0.1 * std::cos(double(7 * k));
      const std::vector<Reaction> found = HeldNodes(scene).reactions(
          r.data(), u.data(), scene.load.empty() ? nullptr : scene.load.data());
      for (const int h : {0, 1}) {
        const Reaction expected = defined_reaction(scene, h, r, u);
        for (size_t d = 0; d < 3; ++d) {
          EXPECT_NEAR(found[size_t(h)].force[d], expected.force[d], 1e-11);
          EXPECT_NEAR(found[size_t(h)].moment[d], expected.moment[d], 1e-11);
          EXPECT_NEAR(found[size_t(h)].about[d], expected.about[d], 1e-14);
        }
      }
    }
}

}  // namespace
}  // namespace elastogen::test
