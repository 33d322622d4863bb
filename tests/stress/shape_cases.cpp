// SPDX-License-Identifier: Apache-2.0
// Extreme shapes: one voxel, none, many loose ones, sheets, needles, hinges, and kinds of pins.
#include "core/error.hpp"
#include "tests/stress/cases.hpp"
#include "tests/stress/equations.hpp"
#include "voxelize/budget.hpp"
#include "voxelize/thin_features.hpp"
#include "voxelize/voxelize.hpp"

#include <map>

namespace elastogen::stress {
namespace {

using Voxel = std::array<int32_t, 3>;

Material rubbery() {
  return test::solid(1e5, 0.3);
}

/// One free voxel falls by g t (t + dt)/2.
void single(Record& record) {
  Scene scene = box_scene(1, 1, 1, 0.1, rubbery());
  const State start = initial_state(scene);
  const Outcome end = run(record, scene, start, {.steps = 60});
  const double t = end.state.time, fall = 9.81 * t * (t + scene.dt) / 2;
  for (int64_t n = 0; n < 8; ++n) {
    const double error = end.state.x(n, 1) - start.x(n, 1) + fall;
    record.expect(std::abs(error) < 1e-10 * fall, "node ", n, " falls wrong by ", error, " m");
  }
}

void empty(Record& record) {
  Surface nothing;
  nothing.vertices = Array<double>(0, 3);
  nothing.triangles = Array<int32_t>(0, 3);
  nothing.material = Array<int32_t>(0, 1);
  expect_error(
      record, [&] { voxelize(nothing); }, ErrorKind::kAsset);
}

/// Pins the layer of nodes of smallest y of every piece and finishes.
void pin_feet(Scene& scene) {
  for (int64_t n = 0; n < scene.grid.node_count(); ++n)
    scene.pinned(n) = scene.grid.node_coord(n, 1) == 0;
  scene.gravity = {4, -9.81, 0};
  finish_scene(scene);
}

/// Bound on the error of a position after some steps of residual <= tolerance:
/// dt^2 g_ref |m| / min m a step, carried on by the velocities.
double error_bound(const Scene& scene, double tolerance, int steps) {
  double squares = 0, least = 1e300;
  for (int64_t n = 0; n < scene.mass.rows(); ++n) {
    if (scene.pinned(n)) continue;
    squares += scene.mass(n) * scene.mass(n);
    least = std::min(least, scene.mass(n));
  }
  const double one = tolerance * 9.81 * std::sqrt(squares) / least * scene.dt * scene.dt;
  return one * steps * (steps + 1) / 2;
}

/// Two pieces of different shape beside each other against their solo runs.
void two_pieces(Record& record) {
  const Plan plan = {.steps = 30, .options = {.tolerance = 1e-6}};
  // a plate and a block, apart from each other
  std::vector<Voxel> both, parts[2];
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 6; ++j) parts[0].push_back({i, j, 0});
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 2; ++k) parts[1].push_back({10 + i, j, k});
  for (const auto& part : parts) both.insert(both.end(), part.begin(), part.end());
  Scene scene = voxel_scene(both, 0.1, rubbery());
  pin_feet(scene);
  const Outcome end = run(record, scene, initial_state(scene), plan);
  const std::string label = record.label;
  record.expect(scene.grid.pieces == 2, scene.grid.pieces, " pieces");
  double largest = 0;
  // each piece alone; nodes are matched by their coordinates
  for (const auto& part : parts) {
    Scene solo = voxel_scene(part, 0.1, rubbery());
    pin_feet(solo);
    const Outcome alone = run(record, solo, initial_state(solo), plan);
    for (int64_t n = 0; n < solo.grid.node_count(); ++n)
      for (int64_t m = 0; m < scene.grid.node_count(); ++m)
        if (std::equal(solo.grid.node_coord.row(n), solo.grid.node_coord.row(n) + 3,
                       scene.grid.node_coord.row(m)))
          for (int d = 0; d < 3; ++d)
            largest = std::max(largest, std::abs(alone.state.x(n, d) - end.state.x(m, d)));
  }
  record.label = label;
  const double bound = 2 * error_bound(scene, 1e-6, plan.steps);
  record.note("largest difference to the solo runs ", largest, " m, bound ", bound, " m");
  record.expect(largest <= bound, "differs from the solo runs by ", largest, " m");
}

/// Many like columns of two voxels against one of them alone.
void like_pieces(Record& record, int count) {
  const Plan plan = {.steps = 10, .options = {.tolerance = 1e-6}, .check_every = 5};
  const int side = int(std::ceil(std::sqrt(count)));
  std::vector<Voxel> voxels;
  for (int p = 0; p < count; ++p)
    for (int j = 0; j < 2; ++j) voxels.push_back({2 * (p % side), j, 2 * (p / side)});
  Scene scene = voxel_scene(voxels, 0.1, rubbery());
  pin_feet(scene);
  const Outcome end = run(record, scene, initial_state(scene), plan);
  const std::string label = record.label;
  record.expect(scene.grid.pieces == count, scene.grid.pieces, " pieces");
  Scene solo = voxel_scene({{0, 0, 0}, {0, 1, 0}}, 0.1, rubbery());
  pin_feet(solo);
  const Outcome alone = run(record, solo, initial_state(solo), plan);
  record.label = label;
  // motion of the solo column by its node (i, j, k)
  std::map<Voxel, Vec3> motion;
  for (int64_t n = 0; n < 12; ++n) {
    const int32_t* at = solo.grid.node_coord.row(n);
    for (int d = 0; d < 3; ++d)
      motion[{at[0], at[1], at[2]}][size_t(d)] = alone.state.x(n, d) - solo.grid.rest(n, d);
  }
  double largest = 0;
  for (int64_t n = 0; n < scene.grid.node_count(); ++n) {
    const int32_t* at = scene.grid.node_coord.row(n);
    for (int d = 0; d < 3; ++d)
      largest = std::max(largest, std::abs(end.state.x(n, d) - scene.grid.rest(n, d) -
                                           motion[{at[0] % 2, at[1], at[2] % 2}][size_t(d)]));
  }
  const double bound = 2 * error_bound(scene, 1e-6, plan.steps);
  record.note("largest difference to the solo run ", largest, " m, bound ", bound, " m");
  record.expect(largest <= bound, "differs from the solo run by ", largest, " m");
}

/// A slender box held at x = 0 for a few steps; memory of a plain run against the budget.
void slender(Record& record, int nx, int ny, int nz) {
  const int64_t base = resident_memory();
  forget_peak();
  Scene scene = box_scene(nx, ny, nz, 0.01, test::solid(1e7, 0.3), 0);
  const Plan plan = {.steps = 5, .check_every = 5};
  plain_run(scene, initial_state(scene), plan);
  const int64_t voxels = scene.grid.voxel_count(), used = peak_memory() - base;
  record.note(used / voxels, " bytes a voxel");
  // below some 1e4 voxels the pools of the threads weigh more than the scene
  record.expect(voxels < 10000 || used <= kBytesPerVoxel * voxels, used, " bytes for ", voxels,
                " voxels, the budget has ", kBytesPerVoxel, " a voxel");
  run(record, scene, initial_state(scene), plan);
}

/// A box a million times as long as thick.
Surface long_box() {
  constexpr int kFaces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  Surface s;
  s.vertices = Array<double>(8, 3);
  s.triangles = Array<int32_t>(12, 3);
  s.material = Array<int32_t>(12);
  for (int c = 0; c < 8; ++c) {
    const double corner[3] = {c & 1 ? 1e6 : 0.0, c & 2 ? 1.0 : 0.0, c & 4 ? 1.0 : 0.0};
    std::copy(corner, corner + 3, s.vertices.row(c));
    s.box.add({corner[0], corner[1], corner[2]});
  }
  for (int f = 0; f < 6; ++f)
    for (int k = 0; k < 3; ++k) {
      s.triangles(2 * f, k) = kFaces[f][k];
      s.triangles(2 * f + 1, k) = kFaces[f][(k + 2) % 4];
    }
  return s;
}

void aspect_refused(Record& record) {
  const Surface surface = long_box();
  forget_peak();
  const int64_t before = peak_memory();
  expect_error(
      record, [&] { voxelize(surface, {.h = 0.01}); }, ErrorKind::kResources);
  const int64_t rise = peak_memory() - before;
  record.expect(rise < 16 << 20, "memory rose by ", rise, " bytes before the refusal");
}

/// Voxels a thousand times as thick as the body.
void aspect_coarse(Record& record) {
  Scene scene = test::scene_on(voxelize(long_box(), {.h = 1e3}).grid, test::solid(1e9, 0.3));
  scene.gravity = {0, -9.81, 0};
  finish_scene(scene);
  record.note(scene.grid.voxel_count(), " voxels");
  run(record, scene, initial_state(scene), {.steps = 3});
}

/// A million voxels in a row, where the box of equal sides would have 1e18 cells.
void aspect_sparse(Record& record) {
  const int64_t base = resident_memory();
  forget_peak();
  const Voxelized result = voxelize(long_box(), {.h = 1});
  const int64_t voxels = result.grid.voxel_count(), used = peak_memory() - base;
  record.note(voxels, " voxels, ", used / voxels, " bytes a voxel");
  record.expect(used <= kBytesPerVoxel * voxels, used, " bytes for ", voxels, " voxels");
  record.label = "voxelised";
}

/// Voxels that hang on edges and corners: the grid check must say so, the run must bear it.
void hinges(Record& record, const std::vector<Voxel>& voxels, int64_t expected) {
  Scene scene = voxel_scene(voxels, 0.1, rubbery());
  const int64_t found = hinge_count(scene.grid);
  const std::vector<Finding> findings = check_grid(scene.grid);
  record.expect(found == expected, found, " hinges found, not ", expected);
  record.expect(std::any_of(findings.begin(), findings.end(),
                            [](const Finding& f) { return f.what == "hinges"; }),
                "no finding names the hinges");
  pin_feet(scene);
  run(record, scene, initial_state(scene), {.steps = 30});
}

std::vector<Voxel> checkerboard(int n) {
  std::vector<Voxel> voxels;
  for (int i = 0; i < n * n * n; ++i)
    if ((i % n + i / n % n + i / n / n) % 2 == 0) voxels.push_back({i % n, i / n % n, i / n / n});
  return voxels;
}

/// A block held at the nodes that the rule picks.
void pins(Record& record, const std::function<bool(const int32_t* at)>& held) {
  Scene scene = box_scene(4, 4, 4, 0.1, test::solid(1e6, 0.3));
  for (int64_t n = 0; n < scene.grid.node_count(); ++n)
    scene.pinned(n) = held(scene.grid.node_coord.row(n));
  finish_scene(scene);
  const State start = initial_state(scene);
  const Outcome end = run(record, scene, start, {.steps = 60});
  for (int64_t n = 0; n < start.x.rows(); ++n)
    for (int d = 0; d < 3; ++d)
      if (scene.pinned(n) && end.state.x(n, d) != start.x(n, d))
        return record.expect(false, "pinned node ", n, " moved");
}

/// At rest the pins carry the weight.
void reaction(Record& record) {
  Scene scene = box_scene(4, 4, 4, 0.1, test::solid(1e6, 0.3), 1);
  scene.dt = 1;
  finish_scene(scene);
  const Plan plan = {.steps = 12, .options = {.tolerance = 1e-5}};
  const Outcome end = run(record, scene, initial_state(scene), plan);
  const Balance b = balance(scene, end.state, end.state, TimeScheme::kEuler);
  double weight = 0, carried[3] = {};
  for (int64_t n = 0; n < scene.mass.rows(); ++n) {
    weight += scene.pinned(n) ? 0 : 9.81 * scene.mass(n);
    for (int d = 0; d < 3 && scene.pinned(n); ++d) carried[d] += b.internal[size_t(3 * n + d)];
  }
  record.note("pins carry ", carried[1], " N of ", weight, " N");
  record.expect(std::abs(carried[1] - weight) < 1e-3 * weight, "pins carry ", carried[1],
                " N, the load is ", weight, " N");
}

}  // namespace

std::vector<Case> shape_cases() {
  const auto slender_case = [](int nx, int ny, int nz) {
    return [=](Record& r) { slender(r, nx, ny, nz); };
  };
  const auto pins_case = [](bool (*held)(const int32_t*)) {
    return [=](Record& r) { pins(r, held); };
  };
  return {
      // shapes
      {"shape.single", true, single},
      {"shape.empty", true, empty},
      {"shape.pieces.2", true, two_pieces},
      {"shape.pieces.1000", true, [](Record& r) { like_pieces(r, 1000); }},
      {"shape.pieces.100000", false, [](Record& r) { like_pieces(r, 100000); }},
      {"shape.sheet.60", true, slender_case(60, 1, 60)},
      {"shape.sheet.300", false, slender_case(300, 1, 300)},
      {"shape.needle.500", true, slender_case(500, 1, 1)},
      {"shape.needle.10000", false, slender_case(10000, 1, 1)},
      {"shape.aspect.refused", true, aspect_refused},
      {"shape.aspect.coarse", true, aspect_coarse},
      {"shape.aspect.sparse", false, aspect_sparse},
      {"shape.checkerboard", true, [](Record& r) { hinges(r, checkerboard(4), 31); }},
      {"shape.edge", true,
       [](Record& r) {
         hinges(r, {{0, 0, 0}, {1, 1, 0}}, 1);
       }},
      {"shape.corner", true,
       [](Record& r) {
         hinges(r, {{0, 0, 0}, {1, 1, 1}}, 1);
       }},
      // pins
      {"pins.all", true, pins_case([](const int32_t*) { return true; })},
      {"pins.one", true,
       pins_case([](const int32_t* a) { return a[0] == 0 && a[1] == 4 && a[2] == 0; })},
      {"pins.collinear", true, pins_case([](const int32_t* a) { return a[1] == 4 && a[2] == 0; })},
      {"pins.plane", true, pins_case([](const int32_t* a) { return a[0] == 0; })},
      {"pins.reaction", true, reaction},
  };
}

}  // namespace elastogen::stress
