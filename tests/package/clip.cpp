// SPDX-License-Identifier: Apache-2.0
// The main job in a user's program: an asset that hangs by its top, as an animation.

#include "core/error.hpp"
#include "scene/run.hpp"

#include <cstdio>

int main(int argc, char** argv) {
  using namespace elastogen;
  if (argc != 3) return 2;
  RunDescription run;
  run.input = argv[1];
  run.outputs = {argv[2]};
  run.size = 0.3;  // [m]
  run.material = material_preset("jelly").material;
  run.energy = EnergySource::kNeural;  // by its net, or not at all
  run.pins = {parse_pin("y>95%")};
  run.voxels = 8;
  run.frames = 10;
  try {
    const RunResult result = run_scene(run);
    std::printf("%lld steps, worst residual %.1e\n", static_cast<long long>(result.report.steps),
                result.report.worst_residual);
    return result.end == ClipEnd::kConverged ? 0 : 1;
  } catch (const Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 3;
  }
}
