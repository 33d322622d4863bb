// SPDX-License-Identifier: Apache-2.0
// Gravity from nothing to 1e4 m/s^2, impacts up to 1e4 m/s, bodies from a micron to a thousand
// kilometres, and far from the origin.
#include "core/error.hpp"
#include "tests/stress/cases.hpp"
#include "tests/stress/equations.hpp"

namespace elastogen::stress {
namespace {

void weightless(Record& record) {
  Scene scene = box_scene(6, 2, 2, 0.05, test::solid(1e6, 0.3));
  scene.gravity = {};
  const State start = initial_state(scene);
  const Outcome end = run(record, scene, start, {.steps = 50});
  record.expect(hash(end.state) == hash(start), "the rest state moved");
}

/// A column stands on pins at rest: its top sinks by rho g L^2 / (2 E) where that is small.
void standing(Record& record, double g) {
  constexpr double h = 0.05, kYoung = 1e7;
  constexpr int kLong = 12;
  Scene scene = box_scene(2, kLong, 2, h, test::solid(kYoung, 0.0), 1);
  scene.gravity = {0, -g, 0};
  scene.dt = 0.1;
  finish_scene(scene);
  const Plan plan = {.steps = 30, .options = {.tolerance = 1e-5 * std::clamp(g, 1e-5, 1.0)}};
  const Outcome end = run(record, scene, initial_state(scene), plan);
  double sum = 0, count = 0;
  for (int64_t n = 0; n < scene.grid.node_count(); ++n)
    if (scene.grid.node_coord(n, 1) == kLong)
      sum += scene.grid.rest(n, 1) - end.state.x(n, 1), ++count;
  const double L = kLong * h, strain = 1000 * g * L / kYoung;
  const double found = sum / count / (strain * L / 2);
  record.note("top sinks by ", found, " of rho g L^2/(2E), strain ", strain);
  if (strain > 0.1) return;
  record.expect(std::abs(found - 1) < 0.02 + strain, "top sinks by ", found, " of rho g L^2/(2E)");
}

void crushed(Record& record) {
  Scene scene = box_scene(3, 6, 3, 0.05, test::solid(1e6, 0.3), 1);
  scene.gravity = {0, -1e4, 0};
  const Outcome end = run(record, scene, initial_state(scene), {.steps = 60});
  record.note(inverted_corners(scene, end.state.x), " inverted corners");
}

void sideways(Record& record) {
  Scene scene = box_scene(8, 2, 2, 0.05, test::solid(1e6, 0.3), 0);
  scene.gravity = {0, 0, 9.81};
  run(record, scene, initial_state(scene), {.steps = 40});
}

/// Gravity turns once in a second.
void turning(Record& record) {
  Scene scene = box_scene(8, 2, 2, 0.05, test::solid(1e6, 0.3), 0);
  Plan plan = {.steps = 60};
  plan.before_step = [](Scene& s, int step) {
    const double angle = 2 * M_PI * step / 60;
    s.gravity = {0, -9.81 * std::cos(angle), 9.81 * std::sin(angle)};
  };
  run(record, scene, initial_state(scene), plan);
}

/// A cube hits the floor: no point passes the contact layer, or the step is refused.
void impact(Record& record, double speed) {
  constexpr double h = 0.05;
  Scene scene = box_scene(4, 4, 4, h, test::solid(1e6, 0.3));
  put_floor(scene, -0.1);
  scene.dt = 1.0 / 240;
  finish_scene(scene);
  double lowest = 1e300;
  Plan plan = {.steps = 60};
  plan.done = [&](const State& s, const StepReport&) {
    lowest = std::min(lowest, lowest_point(scene, s.x));
    return false;
  };
  const Outcome end =
      run(record, scene, initial_state(scene, {.velocity = {0, -speed, 0}, .spin = {}}), plan);
  record.note("lowest point ", lowest / h, " h, ", inverted_corners(scene, end.state.x),
              " inverted corners");
  record.expect(lowest > -h / 4, "a point passed the floor: ", lowest / h, " h");
  record.expect(speed < 10 || lowest < 0 || record.refusals > 0, "never touched the floor");
}

/// Displacement over h of a beam after some steps, all lengths times s, moved by `offset` m.
std::vector<double> dimensionless(Record& record, double s, double offset, double tolerance) {
  const double h = 0.025 * s;
  Scene scene =
      test::scene_on(make_box(10, 3, 3, h, {offset, offset, -offset}), test::solid(1e5 * s, 0.4));
  for (int64_t n = 0; n < scene.grid.node_count(); ++n)
    scene.pinned(n) = scene.grid.node_coord(n, 0) == 0;
  scene.gravity = {0, -9.81, 0};
  scene.dt = std::sqrt(s) / 60;
  finish_scene(scene);
  const Plan plan = {.steps = 8, .options = {.tolerance = tolerance}};
  const Outcome end = run(record, scene, initial_state(scene), plan);
  std::vector<double> u = test::displacement(scene, end.state);
  for (double& value : u) value /= h;
  return u;
}

void compare(Record& record, double s, double offset, double tolerance) {
  const std::vector<double> reference = dimensionless(record, 1, 0, tolerance);
  const std::vector<double> here = dimensionless(record, s, offset, tolerance);
  const double difference = test::relative_difference(here, reference);
  record.note("differs by ", difference);
  record.expect(difference < 1e-6, "differs by ", difference);
  record.expect(record.drafts == 0, "a draft at tolerance ", tolerance);
}

}  // namespace

std::vector<Case> load_cases() {
  std::vector<Case> cases = {
      {"gravity.0", true, weightless},
      {"gravity.1e-6", true, [](Record& r) { standing(r, 1e-6); }},
      {"gravity.9.81", true, [](Record& r) { standing(r, 9.81); }},
      {"gravity.1e4", true, crushed},
      {"gravity.sideways", true, sideways},
      {"gravity.turning", true, turning},
  };
  for (const double speed : {1.0, 10.0, 100.0, 1e3, 1e4})
    cases.push_back({concat("impact.", speed), true, [=](Record& r) { impact(r, speed); }});
  // the beam is a quarter of a metre long at s = 1
  for (int decade = -6; decade <= 6; ++decade)
    cases.push_back({concat("scale.1e", decade), true,
                     [=](Record& r) { compare(r, 4 * std::pow(10.0, decade), 0, 1e-6); }});
  cases.push_back({"offset.1e6", true, [](Record& r) { compare(r, 1, 0.25e6, 1e-5); }});
  return cases;
}

}  // namespace elastogen::stress
