// SPDX-License-Identifier: Apache-2.0
// Starts far from rest: every law has a finite force everywhere, so each of them must end in an
// equilibrium that can be named.
#include "core/error.hpp"
#include "tests/stress/cases.hpp"
#include "tests/stress/equations.hpp"

namespace elastogen::stress {
namespace {

constexpr double kEdge = 0.1;  // h [m]
constexpr int kStartSteps = 500;
constexpr double kStill = 1e-4;    // change of shape in a step, of the body's length
constexpr double kInShape = 1e-3;  // of the body's length

struct NamedLaw {
  const char* name;
  Law law;
};
constexpr NamedLaw kLaws[] = {{"nh", Law::kNeoHookean},
                              {"stable", Law::kStableNeoHookean},
                              {"corotated", Law::kFixedCorotated},
                              {"stvk", Law::kStvk}};

Scene free_cube(int n, Law law) {
  Scene scene = box_scene(n, n, n, kEdge, test::solid(1e5, 0.3, law));
  scene.gravity = {};
  return scene;
}

double length(const Scene& scene) {
  return kEdge * std::cbrt(double(scene.grid.voxel_count()));
}

double fastest(const State& state) {
  double largest = 0;
  for (int64_t k = 0; k < state.v.size(); ++k)
    largest = std::max(largest, std::abs(state.v.data()[k]));
  return largest;
}

/// Runs until the body is in shape or keeps another shape, both up to rigid motion, and names the
/// end.
void settle(Record& record, Scene& scene, const State& start, bool may_stay_folded) {
  const double L = length(scene);
  const Array<double>& rest = scene.grid.rest;
  // until it is in shape or at rest
  Plan plan;
  plan.steps = kStartSteps;
  plan.done = [&](const State& s, const StepReport& r) {
    if (r.step < 20 || !r.converged) return false;
    return shape_distance(s.x, rest) < kInShape / 4 * L || fastest(s) < 1e-7 * L / scene.dt;
  };
  const Outcome end = run(record, scene, start, plan);
  if (end.reports.empty()) return;
  // distance from rest, and whether it still moves
  const double away = shape_distance(end.state.x, rest) / L;
  const double change = shape_distance(end.state.x, end.state.x_before) / L;
  const double speed = fastest(end.state) * scene.dt / L;
  const int64_t inverted = inverted_corners(scene, end.state.x);
  const bool still = change < kStill && end.reports.back().converged;
  // the name of the end
  record.label = away <= kInShape ? "at rest" : inverted == 0 ? "elsewhere" : "folded";
  if (record.label == "folded" && !still) record.label = "folded, moving";
  if (away > kInShape)
    record.note(inverted, " inverted corners, ", away, " L from rest; a step changes the shape by ",
                change, " L, the fastest node moves ", speed, " L");
  if (record.drafts > 0) record.note(record.drafts, " steps are drafts");
  record.expect(away <= kInShape || (still && inverted > 0) || may_stay_folded, "neither at rest ",
                "nor in a folded equilibrium after ", end.reports.size(), " steps: ", away,
                " L from rest, the shape changes by ", change, " L a step");
}

void random_start(Record& record, Law law, unsigned seed) {
  Scene scene = free_cube(3, law);
  State state = initial_state(scene);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, length(scene));
  for (int64_t k = 0; k < state.x.size(); ++k) state.x.data()[k] = uniform(random);
  settle(record, scene, state, law == Law::kStvk);
}

/// Sets the last coordinates of every node to that of the centre.
void flattened(Record& record, Law law, int first_flat) {
  Scene scene = free_cube(3, law);
  State state = initial_state(scene);
  for (int64_t n = 0; n < state.x.rows(); ++n)
    for (int d = first_flat; d < 3; ++d) state.x(n, d) = length(scene) / 2;
  if (first_flat > 0) return settle(record, scene, state, law == Law::kStvk || first_flat == 1);
  // all at one point: an equilibrium of laws that are smooth at F = 0
  Plan plan;
  const Outcome end = run(record, scene, state, plan);
  if (end.reports.empty()) return;
  const StepReport& last = end.reports.back();
  record.note("min J ", last.min_j, ", ",
              shape_distance(end.state.x, scene.grid.rest) / length(scene), " L from rest");
  if (last.min_j <= 0) record.label += ", collapsed";
}

void mirrored(Record& record, Law law) {
  Scene scene = free_cube(3, law);
  State state = initial_state(scene);
  for (int64_t n = 0; n < state.x.rows(); ++n) state.x(n, 0) = length(scene) - state.x(n, 0);
  settle(record, scene, state, law == Law::kStvk);
}

/// The middle voxel of a cube turned inside out.
void inverted_voxel(Record& record, Law law) {
  Scene scene = free_cube(3, law);
  State state = initial_state(scene);
  for (int64_t v = 0; v < scene.grid.voxel_count(); ++v) {
    const int32_t* at = scene.grid.voxel_coord.row(v);
    if (at[0] != 1 || at[1] != 1 || at[2] != 1) continue;
    for (int c = 0; c < 8; ++c) {
      double& x = state.x(scene.grid.corners(v, c), 0);
      x = 3 * kEdge - x;
    }
  }
  settle(record, scene, state, law == Law::kStvk);
}

/// A voxel whose upper face is turned about its normal.
void twisted(Record& record, Law law, double angle) {
  Scene scene = free_cube(1, law);
  State state = initial_state(scene);
  for (int64_t n = 0; n < state.x.rows(); ++n) {
    if (state.x(n, 1) < kEdge / 2) continue;
    const double a = state.x(n, 0) - kEdge / 2, b = state.x(n, 2) - kEdge / 2;
    state.x(n, 0) = kEdge / 2 + std::cos(angle) * a - std::sin(angle) * b;
    state.x(n, 2) = kEdge / 2 + std::sin(angle) * a + std::cos(angle) * b;
  }
  settle(record, scene, state, law == Law::kStvk);
}

}  // namespace

std::vector<Case> start_cases() {
  std::vector<Case> cases;
  for (const auto& [name, law] : kLaws) {
    const std::string n = name;
    const Law l = law;
    for (unsigned seed = 0; seed < 100; ++seed)
      cases.push_back({concat("start.random.", n, '.', seed), seed < 8,
                       [=](Record& r) { random_start(r, l, seed); }});
    const char* flat[] = {"point", "line", "plane"};
    for (int k = 0; k < 3; ++k)
      cases.push_back(
          {concat("start.flat.", flat[k], '.', n), true, [=](Record& r) { flattened(r, l, k); }});
    cases.push_back({"start.mirrored." + n, true, [=](Record& r) { mirrored(r, l); }});
    cases.push_back({"start.inverted." + n, true, [=](Record& r) { inverted_voxel(r, l); }});
    for (const int degrees : {90, 180})
      cases.push_back({concat("start.twisted.", degrees, '.', n), true,
                       [=](Record& r) { twisted(r, l, degrees * M_PI / 180); }});
  }
  return cases;
}

}  // namespace elastogen::stress
