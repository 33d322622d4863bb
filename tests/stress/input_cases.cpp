// SPDX-License-Identifier: Apache-2.0
// Broken numbers in every input of a scene, a state and the options: an Error before the first
// step.
#include "core/error.hpp"
#include "tests/stress/cases.hpp"

#include <limits>

namespace elastogen::stress {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Everything that a caller gives.
struct Input {
  Scene scene;
  State state;
  SolverOptions options;
};

/// Two voxels above a floor, with a material of their own each and a step before.
Input sound() {
  Input in;
  in.scene = test::scene_on(make_box(2, 1, 1, 0.1), test::solid(1e5, 0.3));
  in.scene.gravity = {0, -9.81, 0};
  put_floor(in.scene, -0.05);
  finish_scene(in.scene);
  in.state = initial_state(in.scene);
  in.scene.scheme = TimeScheme::kBdf2;
  in.state.x_before = in.state.x;
  in.state.v_before = in.state.v;
  return in;
}

using Change = std::function<void(Input&)>;

/// Breaks the input, finishes the scene anew and takes a step.
void attempt(const Change& change) {
  Input in = sound();
  change(in);
  finish_scene(in.scene);
  Solver solver(in.scene, in.options);
  solver.step(in.state);
}

Case refused(const std::string& name, const Change& change) {
  return {"input." + name, true, [=](Record& r) {
            expect_error(
                r, [&] { attempt(change); }, ErrorKind::kUsage);
          }};
}

/// The untouched input is accepted, else the other cases say nothing.
void accepted(Record& record) {
  attempt([](Input&) {});
  record.label = "accepted";
}

/// A length so small that its square is no number: refused, or a finite run with the same bits.
void denormal(Record& record) {
  try {
    Scene scene = test::scene_on(make_box(2, 1, 1, 1e-310), test::solid(1e5, 0.3));
    scene.gravity = {0, -9.81, 0};
    finish_scene(scene);
    run(record, scene, initial_state(scene), {.steps = 3});
  } catch (const Error& error) {
    record.label = concat("refused: ", error.what());
  }
}

using Numbers = Array<double>& (*)(Input&);
struct NumberArray {
  const char* name;
  Numbers of;
};
constexpr NumberArray kArrays[] = {
    {"fill", [](Input& in) -> Array<double>& { return in.scene.grid.fill; }},
    {"shape_mean", [](Input& in) -> Array<double>& { return in.scene.grid.shape_mean; }},
    {"rest", [](Input& in) -> Array<double>& { return in.scene.grid.rest; }},
    {"surface.weights", [](Input& in) -> Array<double>& { return in.scene.surface.weights; }},
    {"surface.area", [](Input& in) -> Array<double>& { return in.scene.surface.area; }},
    {"surface.position", [](Input& in) -> Array<double>& { return in.scene.surface.position; }},
    {"state.x", [](Input& in) -> Array<double>& { return in.state.x; }},
    {"state.v", [](Input& in) -> Array<double>& { return in.state.v; }},
    {"state.x_before", [](Input& in) -> Array<double>& { return in.state.x_before; }},
    {"state.v_before", [](Input& in) -> Array<double>& { return in.state.v_before; }},
};

using Number = double& (*)(Input&);
struct NamedNumber {
  const char* name;
  Number of;
  bool positive;  ///< zero and below must be refused as well
};
constexpr NamedNumber kNumbers[] = {
    {"dt", [](Input& in) -> double& { return in.scene.dt; }, true},
    {"h", [](Input& in) -> double& { return in.scene.grid.h; }, true},
    {"young", [](Input& in) -> double& { return in.scene.materials[0].young; }, true},
    {"density", [](Input& in) -> double& { return in.scene.materials[0].density; }, true},
    {"tolerance", [](Input& in) -> double& { return in.options.tolerance; }, true},
    {"poisson", [](Input& in) -> double& { return in.scene.materials[0].poisson; }, false},
    {"gravity", [](Input& in) -> double& { return in.scene.gravity[1]; }, false},
    {"volume", [](Input& in) -> double& { return in.scene.grid.volume; }, false},
};

/// Faulty inputs that are not a single number out of its range.
std::vector<Case> misfits() {
  return {
      refused("fill.zero", [](Input& in) { in.scene.grid.fill(1) = 0; }),
      refused("fill.negative", [](Input& in) { in.scene.grid.fill(1) = -0.5; }),
      refused("area.negative", [](Input& in) { in.scene.surface.area(1) = -1; }),
      refused("corners.outside", [](Input& in) { in.scene.grid.corners(1, 3) = 1000; }),
      refused("corners.negative", [](Input& in) { in.scene.grid.corners(1, 3) = -1; }),
      refused("voxels.outside", [](Input& in) { in.scene.grid.voxels(1, 3) = 1000; }),
      refused("material.outside", [](Input& in) { in.scene.material(1) = 7; }),
      refused("material.negative", [](Input& in) { in.scene.material(1) = -1; }),
      refused("surface.voxel.outside", [](Input& in) { in.scene.surface.voxel(1) = 1000; }),
      refused("surface.voxel.negative", [](Input& in) { in.scene.surface.voxel(1) = -1; }),
      refused("surface.short", [](Input& in) { in.scene.surface.area = Array<double>(1); }),
      refused("pinned.short", [](Input& in) { in.scene.pinned = Array<uint8_t>(1); }),
      refused("materials.none", [](Input& in) { in.scene.materials.clear(); }),
      refused("state.x.short", [](Input& in) { in.state.x = Array<double>(1, 3); }),
      refused("state.v.short", [](Input& in) { in.state.v = Array<double>(1, 3); }),
      refused("state.x_before.short", [](Input& in) { in.state.x_before = Array<double>(1, 3); }),
      refused("state.v_before.short", [](Input& in) { in.state.v_before = Array<double>(1, 3); }),
      refused("max_outer.negative", [](Input& in) { in.options.max_outer = -1; }),
      refused("max_inner.negative", [](Input& in) { in.options.max_inner = -1; }),
      refused("voxels.none", [](Input& in) { in.scene.grid = VoxelGrid{}; }),
  };
}

}  // namespace

std::vector<Case> input_cases() {
  std::vector<Case> cases = {{"input.sound", true, accepted}, {"input.denormal", true, denormal}};
  for (const auto& [what, value] : {std::pair{".nan", kNan}, {".inf", kInfinity}}) {
    const double v = value;
    for (const NumberArray& a : kArrays)
      cases.push_back(refused(concat(a.name, what), [=](Input& in) { a.of(in)(1) = v; }));
    for (const NamedNumber& n : kNumbers)
      cases.push_back(refused(concat(n.name, what), [=](Input& in) { n.of(in) = v; }));
  }
  for (const NamedNumber& n : kNumbers) {
    if (!n.positive) continue;
    cases.push_back(refused(concat(n.name, ".zero"), [=](Input& in) { n.of(in) = 0; }));
    cases.push_back(refused(concat(n.name, ".negative"), [=](Input& in) { n.of(in) = -1; }));
  }
  const std::vector<Case> more = misfits();
  cases.insert(cases.end(), more.begin(), more.end());
  return cases;
}

}  // namespace elastogen::stress
