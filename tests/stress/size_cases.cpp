// SPDX-License-Identifier: Apache-2.0
// Many voxels dropped on the floor: memory and time of a voxel must not grow with their number.
#include "core/error.hpp"
#include "tests/stress/cases.hpp"
#include "voxelize/budget.hpp"

#include <algorithm>

namespace elastogen::stress {
namespace {

constexpr int kSizeSteps = 8;
constexpr double kGrowth = 2;  // of memory and time a voxel, against 1e4 voxels

struct Cost {
  double bytes = 0, ms = 0, work = 0;  ///< a voxel; ms and evaluations of the median step
};

/// A cube of side^3 voxels just above the floor, falling at 1 m/s.
Scene falling(int side) {
  Scene scene = test::scene_on(make_box(side, side, side, 0.02), test::solid(1e5, 0.4));
  put_floor(scene, -0.005);
  scene.gravity = {0, -9.81, 0};
  scene.dt = 1.0 / 120;
  finish_scene(scene);
  return scene;
}

State thrown(const Scene& scene) {
  return initial_state(scene, {.velocity = {0, -1, 0}, .spin = {}});
}

Cost measure(int side) {
  const int64_t base = resident_memory();
  forget_peak();
  Scene scene = falling(side);
  const Outcome end = plain_run(scene, thrown(scene), {.steps = kSizeSteps});
  const auto voxels = double(scene.grid.voxel_count());
  std::vector<double> ms, work;
  for (const StepReport& r : end.reports) ms.push_back(r.ms), work.push_back(r.inner);
  std::sort(ms.begin(), ms.end());
  std::sort(work.begin(), work.end());
  return {double(peak_memory() - base) / voxels, ms[kSizeSteps / 2] / voxels, work[kSizeSteps / 2]};
}

/// Cubes of about 1e4, 1e5 and 1e6 voxels: 22^3, 46^3, 100^3.
void size(Record& record, int side) {
  const Cost small = measure(22), cost = side == 22 ? small : measure(side);
  record.note(side * side * side, " voxels: ", cost.bytes, " bytes and ", 1e3 * cost.ms,
              " us a voxel and step, ", cost.work, " evaluations; 10648 voxels: ", small.bytes,
              " bytes, ", 1e3 * small.ms, " us, ", small.work);
  record.expect(cost.bytes <= kBytesPerVoxel, cost.bytes, " bytes a voxel, the budget has ",
                kBytesPerVoxel);
  record.expect(cost.bytes <= kGrowth * small.bytes, "memory a voxel grows by ",
                cost.bytes / small.bytes);
  record.expect(cost.ms <= kGrowth * small.ms, "time a voxel grows by ", cost.ms / small.ms);
  Scene scene = falling(side);
  const Plan plan = {.steps = kSizeSteps,
                     .check_every = side > 50 ? 6 : 1,
                     .repeated_steps = side > 50 ? 4 : kSizeSteps};
  const Outcome end = run(record, scene, thrown(scene), plan);
  const double lowest = lowest_point(scene, end.state.x) / scene.grid.h;
  record.expect(lowest > -0.25, "a point passed the floor: ", lowest, " h");
}

}  // namespace

std::vector<Case> size_cases() {
  return {{"size.10648", true, [](Record& r) { size(r, 22); }},
          {"size.97336", false, [](Record& r) { size(r, 46); }},
          {"size.1000000", false, [](Record& r) { size(r, 100); }}};
}

}  // namespace elastogen::stress
