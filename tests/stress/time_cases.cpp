// SPDX-License-Identifier: Apache-2.0
// Time steps over four decades to one end time, and long runs.
#include "core/error.hpp"
#include "tests/stress/cases.hpp"

namespace elastogen::stress {
namespace {

/// A short post under gravity from the side, let go; its slowest vibration takes about 10 ms, so
/// that one second of implicit Euler damps it out at any time step.
Scene post(double dt) {
  Scene scene = box_scene(2, 3, 2, 0.05, test::solid(1e7, 0.3), 1);
  scene.gravity = {9.81, 0, 0};
  scene.dt = dt;
  finish_scene(scene);
  return scene;
}

Array<double> motion_at_end(Record& record, Scene& scene, int steps, double tolerance) {
  const Plan plan = {.steps = steps,
                     .options = {.tolerance = tolerance},
                     .check_every = steps > 2000 ? 10 : 1,
                     .repeated_steps = 500};
  Array<double> u = run(record, scene, initial_state(scene), plan).state.x;
  for (int64_t k = 0; k < u.size(); ++k) u.data()[k] -= scene.grid.rest.data()[k];
  return u;
}

double size(const Array<double>& a) {
  return std::max(largest_difference(a, Array<double>(a.rows(), a.cols())), 1e-300);
}

/// The end state after one second against that of the largest step.
void settled(Record& record, double dt) {
  Scene reference = post(1);
  const Array<double> rest = motion_at_end(record, reference, 10, 1e-5);
  Scene scene = post(dt);
  const Array<double> end = motion_at_end(record, scene, int(std::lround(1 / dt)), 1e-5);
  const double difference = largest_difference(end, rest) / size(rest);
  record.note("end state differs by ", difference);
  record.expect(difference < 1e-3, "the end state differs by ", difference);
}

/// A soft beam swings; the error against dt falls with slope 1.
void order(Record& record) {
  constexpr double kEnd = 0.25;
  std::vector<Array<double>> ends;
  for (int steps = 32; steps <= 512; steps *= 2) {
    Scene scene = box_scene(8, 2, 2, 0.05, test::solid(5e5, 0.3), 0);
    scene.dt = kEnd / steps;
    finish_scene(scene);
    ends.push_back(motion_at_end(record, scene, steps, 1e-6));
  }
  double last = 1e300;
  for (size_t k = 2; k < ends.size(); ++k) {
    const double slope = std::log2(largest_difference(ends[k - 1], ends[k - 2]) /
                                   largest_difference(ends[k], ends[k - 1]));
    record.note("slope up to ", 32 << k, " steps ", slope);
    last = slope;
  }
  record.expect(last >= 0.9, "the slope is ", last);
}

/// Memory [bytes] after a tenth of the steps and after all of them, of a run that keeps nothing.
std::pair<int64_t, int64_t> memory_of(const Scene& scene, int steps) {
  Solver solver(scene, {});
  State state = initial_state(scene);
  std::pair<int64_t, int64_t> memory;
  for (int k = 1; k <= steps; ++k) {
    solver.step(state);
    if (k == steps / 10) memory.first = resident_memory();
  }
  memory.second = resident_memory();
  return memory;
}

/// Many steps of a small pinned scene: memory and end state stay, time is counted in steps.
void long_run(Record& record, int steps) {
  Scene scene = box_scene(2, 4, 2, 0.05, test::solid(1e6, 0.3), 1);
  scene.gravity = {9.81, 0, 0};
  const auto [warm, last] = memory_of(scene, steps);
  State middle;
  Plan plan = {.steps = steps, .check_every = 100, .repeated_steps = 1000};
  plan.done = [&](const State& s, const StepReport& r) {
    if (r.step == steps / 2) middle = s;
    return false;
  };
  const Outcome end = run(record, scene, initial_state(scene), plan);
  const double drift = largest_difference(end.state.x, middle.x);
  Array<double> u = end.state.x;
  for (int64_t k = 0; k < u.size(); ++k) u.data()[k] -= scene.grid.rest.data()[k];
  record.note("memory ", warm / 1024, " kB after a tenth, ", last / 1024, " kB at the end; drift ",
              drift / size(u), " of the deflection");
  record.expect(double(last) <= 1.01 * double(warm), "memory grew from ", warm, " to ", last,
                " bytes");
  record.expect(drift < 1e-3 * size(u), "drifts by ", drift, " m");
  record.expect(end.state.time == steps * scene.dt, "time is ", end.state.time);
}

}  // namespace

std::vector<Case> time_cases() {
  std::vector<Case> cases;
  for (int k = 0; k <= 12; ++k) {
    const double dt = std::pow(10.0, -k / 3.0);
    cases.push_back({concat("time.settled.", dt), dt > 2e-3, [=](Record& r) { settled(r, dt); }});
  }
  cases.push_back({"time.order", true, order});
  cases.push_back({"time.long.2000", true, [](Record& r) { long_run(r, 2000); }});
  cases.push_back({"time.long.100000", false, [](Record& r) { long_run(r, 100000); }});
  return cases;
}

}  // namespace elastogen::stress
