// SPDX-License-Identifier: Apache-2.0
#include "cli/run.hpp"
#include "cli/scene_options.hpp"
#include "cli/signals.hpp"
#include "cli/verbs.hpp"
#include "io/read_asset.hpp"
#include "io/scene_file.hpp"

#include <chrono>
#include <cstdio>

namespace elastogen {

int animate(const AnimateOptions& options) {
  if (options.print_resolved) {
    std::fputs(scene_json(resolved_scene(options)).c_str(), stdout);
    return kExitDone;
  }
  watch_signals();
  const auto start = std::chrono::steady_clock::now();
  const Asset asset = read_asset(options.input);
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return run_animation(asset, options, seconds).code;
}

}  // namespace elastogen
