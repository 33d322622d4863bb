// SPDX-License-Identifier: Apache-2.0
#include "cli/run.hpp"
#include "cli/signals.hpp"
#include "cli/verbs.hpp"
#include "core/step_verdict.hpp"
#include "voxelize/demo_character.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

constexpr int kFrames = 55;
constexpr int kRows = 12;         // approximate rows of the table of certificates
constexpr double kFloor = -0.35;  // height of the floor, below the character's feet [m]

AnimateOptions demo_scene(const DemoOptions& options) {
  AnimateOptions o;
  o.input = "demo";
  o.outputs = {options.folder + "/demo.glb", options.folder + "/demo.png"};
  o.pins = {parse_pin("x>97%")};  // a hand
  o.floor = FloorPlane{1, kFloor};
  o.materials = {{"body", Law::kNeoHookean, 4e5, 0.4, 400},
                 {"head", Law::kStableNeoHookean, 1.5e5, 0.4, 250}};
  o.material_of = demo_regions;
  o.voxels = 36;
  o.frames = kFrames;
  o.threads = options.threads;
  o.quiet = options.quiet;
  o.command = options.command;
  return o;
}

void print_certificates(const std::vector<StepReport>& steps) {
  fmt::print("\n  frame   time s   residual   converged    outer   min J   overlap h      ms\n");
  const size_t stride = std::max<size_t>(1, steps.size() / kRows);
  for (size_t k = stride - 1; k < steps.size(); k += stride) {
    const StepReport& r = steps[k];
    fmt::print("  {:5}   {:6.3f}   {:8.2e}   {:>9}   {:6}   {:5.3f}   {:9.3f}   {:5.1f}\n",
               std::lround(r.time * 30), r.time, r.residual, is_converged(r) ? "yes" : "draft",
               r.outer, r.min_j, r.deepest_overlap, r.ms);
  }
}

}  // namespace

int demo(const DemoOptions& options) {
  watch_signals();
  const Asset asset = demo_character();
  const AnimateOptions scene = demo_scene(options);
  std::vector<StepReport> steps;
  RunHooks hooks;
  hooks.on_step = [&](const StepReport& r) { steps.push_back(r); };
  const CommandResult result = run_animation(asset, scene, 0, hooks);

  if (!options.quiet) {
    print_certificates(steps);
    fmt::print("\nwrote {0}/demo.glb and {0}/demo.png\n", options.folder);
  }
  return result.code;
}

}  // namespace elastogen
