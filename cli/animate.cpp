// SPDX-License-Identifier: Apache-2.0
#include "cli/run.hpp"
#include "cli/scene_options.hpp"
#include "cli/signals.hpp"
#include "cli/verbs.hpp"
#include "core/stopwatch.hpp"
#include "io/scene_file.hpp"
#include "scene/asset_stages.hpp"

#include <cstdio>

namespace elastogen {

int animate(const AnimateOptions& options) {
  if (options.print_resolved) {
    std::fputs(scene_json(resolved_scene(options)).c_str(), stdout);
    return kExitDone;
  }
  watch_signals();
  const Stopwatch watch;
  if (options.fem && is_tet_file(options.input)) {
    const TetAsset tets = read_tet_asset(options.input);
    RunHooks hooks;
    hooks.tets = &tets;
    return run_animation(tets.asset, options, watch.seconds(), hooks).code;
  }
  const Asset asset = run_asset(options);
  return run_animation(asset, options, watch.seconds()).code;
}

}  // namespace elastogen
