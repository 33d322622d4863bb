// SPDX-License-Identifier: Apache-2.0
// Moduli over nine decades and mixed, Poisson's ratio up to the limit, heavy on light.
#include "core/error.hpp"
#include "tests/stress/cases.hpp"
#include "tests/stress/equations.hpp"

namespace elastogen::stress {
namespace {

constexpr double kGravity = 9.81;

void modulus(Record& record, double young) {
  Scene scene = box_scene(6, 2, 2, 0.05, test::solid(young, 0.3), 0);
  run(record, scene, initial_state(scene), {.steps = 15});
}

/// A beam whose half at the clamp is 1e9 times as soft as the other, or as stiff.
void mixed(Record& record, double inner, double outer) {
  Scene scene = box_scene(8, 2, 2, 0.05, test::solid(inner, 0.3), 0);
  scene.materials.push_back(test::solid(outer, 0.3));
  for (int64_t v = 0; v < scene.grid.voxel_count(); ++v)
    scene.material(v) = scene.grid.voxel_coord(v, 0) >= 4;
  finish_scene(scene);
  run(record, scene, initial_state(scene), {.steps = 15});
}

/// A column hangs from its upper end at rest: away from the clamp the stress is rho g z, and the
/// volume grows by (1 - 2 nu) rho g z / E.
void poisson(Record& record, double nu) {
  constexpr int kLong = 16;
  constexpr double kYoung = 4e6, kDensity = 1000, h = 0.05;
  Scene scene = box_scene(2, kLong, 2, h, test::solid(kYoung, nu, Law::kNeoHookean, kDensity));
  for (int64_t n = 0; n < scene.grid.node_count(); ++n)
    scene.pinned(n) = scene.grid.node_coord(n, 1) == kLong;
  scene.dt = 0.25;
  finish_scene(scene);
  const Plan plan = {.steps = 20, .options = {.tolerance = 1e-4}};
  const Outcome end = run(record, scene, initial_state(scene), plan);
  const std::vector<double> J = voxel_jacobians(scene, end.state.x);
  double found = 0, expected = 0;
  for (int64_t v = 0; v < scene.grid.voxel_count(); ++v) {
    const int32_t level = scene.grid.voxel_coord(v, 1);
    if (level >= kLong - 5) continue;
    found += J[size_t(v)] - 1;
    expected += (1 - 2 * nu) * kDensity * kGravity * h * (level + 0.5) / kYoung;
  }
  record.note("volume change ", found / expected, " of the analytic one");
  const bool draft = record.drafts > 0 && nu > 0.499;
  record.expect(draft || (found <= 1.5 * expected && found >= expected / 1.5), "volume change is ",
                found / expected, " of the analytic one");
}

void rejected_poisson(Record& record, double nu) {
  expect_error(
      record, [&] { box_scene(1, 1, 1, 0.1, test::solid(1e5, nu)); }, ErrorKind::kUsage);
}

/// Mean height of the nodes of a layer above the rest height.
double layer_motion(const Scene& scene, const Array<double>& x, int layer) {
  double sum = 0, count = 0;
  for (int64_t n = 0; n < x.rows(); ++n)
    if (scene.grid.node_coord(n, 1) == layer) sum += x(n, 1) - scene.grid.rest(n, 1), ++count;
  return sum / count;
}

/// A block a million times as dense on a light one: let go, it presses the light one by at most
/// twice the static amount, and comes to rest at the static amount.
void density(Record& record, double light, double heavy) {
  // the heavy half lies on the light one
  const auto make = [&](double dt) {
    Scene scene =
        box_scene(3, 6, 3, 0.1, test::solid(1e4 * heavy, 0.3, Law::kNeoHookean, light), 1);
    scene.materials.push_back(scene.materials[0]);
    scene.materials[1].density = heavy;
    for (int64_t v = 0; v < scene.grid.voxel_count(); ++v)
      scene.material(v) = scene.grid.voxel_coord(v, 1) >= 3;
    scene.dt = dt;
    finish_scene(scene);
    return scene;
  };
  // static, by steps of 10 s
  Scene slow = make(10);
  const Outcome still = run(record, slow, initial_state(slow), {.steps = 10});
  const double rest = -layer_motion(slow, still.state.x, 3);
  // dynamic, until it rests
  Scene scene = make(1.0 / 60);
  double deepest = 0;
  Plan plan = {.steps = 120};
  plan.done = [&](const State& s, const StepReport&) {
    deepest = std::max(deepest, -layer_motion(scene, s.x, 3));
    return false;
  };
  const Outcome end = run(record, scene, initial_state(scene), plan);
  const double last = -layer_motion(scene, end.state.x, 3);
  record.note("static ", rest, " m, deepest ", deepest, " m, at the end ", last, " m");
  record.expect(rest > 0 && deepest <= 2.1 * rest, "pressed by ", deepest, " m, static ", rest);
  record.expect(std::abs(last - rest) < 0.02 * rest, "ends at ", last, " m, static ", rest);
}

}  // namespace

std::vector<Case> material_cases() {
  std::vector<Case> cases;
  for (int decade = 3; decade <= 12; ++decade)
    cases.push_back({concat("material.young.1e", decade), true,
                     [=](Record& r) { modulus(r, std::pow(10.0, decade)); }});
  cases.push_back({"material.mixed.soft_root", true, [](Record& r) { mixed(r, 1e3, 1e12); }});
  cases.push_back({"material.mixed.stiff_root", true, [](Record& r) { mixed(r, 1e12, 1e3); }});
  for (const double nu : {0.0, 0.3, 0.45, 0.49, 0.499, 0.4999})
    cases.push_back({concat("material.poisson.", nu), true, [=](Record& r) { poisson(r, nu); }});
  for (const double nu : {0.5, -1.0})
    cases.push_back(
        {concat("material.poisson.", nu), true, [=](Record& r) { rejected_poisson(r, nu); }});
  cases.push_back({"material.density.heavy_on_light", true, [](Record& r) { density(r, 1, 1e6); }});
  return cases;
}

}  // namespace elastogen::stress
