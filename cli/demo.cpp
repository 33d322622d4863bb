// SPDX-License-Identifier: Apache-2.0
#include "cli/contact_sheet.hpp"
#include "cli/run.hpp"
#include "cli/signals.hpp"
#include "cli/verbs.hpp"
#include "io/byte_reader.hpp"
#include "voxelize/demo_character.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

constexpr int kFrames = 55;
constexpr int kTiles = 12;
constexpr double kFloor = -0.35;  // below the character's feet [m]

AnimateOptions demo_scene(const DemoOptions& options) {
  AnimateOptions o;
  o.input = "demo";
  o.outputs = {options.folder + "/demo.glb"};
  o.pins = {"x>97%"};  // a hand
  o.floor = FloorOption{1, kFloor};
  o.voxels = 36;
  o.frames = kFrames;
  o.threads = options.threads;
  o.quiet = options.quiet;
  o.command = options.command;
  return o;
}

/// sRGB of each surface vertex: the character's own colours, linear in the asset.
Array<float> colours(const Asset& asset) {
  const Mesh& mesh = asset.meshes[0];
  Array<float> result(int64_t(mesh.position.size()), 3);
  for (size_t v = 0; v < mesh.position.size(); ++v)
    for (int i = 0; i < 3; ++i)
      result(int64_t(v), i) =
          mesh.colour.empty() ? 0.8f : srgb_from_linear(mesh.colour[v][size_t(i)]);
  return result;
}

void print_certificates(const std::vector<StepReport>& steps) {
  fmt::print("\n  frame   time s   residual   converged    outer   min J   overlap h      ms\n");
  const size_t stride = std::max<size_t>(1, steps.size() / kTiles);
  for (size_t k = stride - 1; k < steps.size(); k += stride) {
    const StepReport& r = steps[k];
    fmt::print("  {:5}   {:6.3f}   {:8.2e}   {:>9}   {:6}   {:5.3f}   {:9.3f}   {:5.1f}\n",
               std::lround(r.time * 30), r.time, r.residual, r.converged ? "yes" : "draft", r.outer,
               r.min_j, r.deepest_overlap, r.ms);
  }
}

}  // namespace

int demo(const DemoOptions& options) {
  watch_signals();
  const Asset asset = demo_character();
  const AnimateOptions scene = demo_scene(options);
  std::vector<Array<double>> frames;
  std::vector<StepReport> steps;
  RunHooks hooks;
  hooks.materials = {{"body", Law::kNeoHookean, 4e5, 0.4, 400},
                     {"head", Law::kStableNeoHookean, 1.5e5, 0.4, 250}};
  hooks.regions = demo_regions;
  hooks.on_step = [&](const StepReport& r) { steps.push_back(r); };
  hooks.on_frame = [&, frame = 0](const Array<double>& positions) mutable {
    if (frame++ % (kFrames / (kTiles - 1)) == 0) frames.push_back(positions);
  };
  const RunResult result = run_animation(asset, scene, 0, hooks);

  const Surface surface = pose_surface(asset);
  write_contact_sheet(options.folder + "/demo.png", frames, surface.triangles, colours(asset),
                      {.floor = kFloor});
  if (!options.quiet) {
    print_certificates(steps);
    fmt::print("\nwrote {0}/demo.glb and {0}/demo.png\n", options.folder);
  }
  return result.code;
}

}  // namespace elastogen
