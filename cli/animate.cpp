// SPDX-License-Identifier: Apache-2.0
#include "cli/run.hpp"
#include "cli/signals.hpp"
#include "cli/verbs.hpp"
#include "io/read_asset.hpp"

#include <chrono>

namespace elastogen {

int animate(const AnimateOptions& options) {
  watch_signals();
  const auto start = std::chrono::steady_clock::now();
  const Asset asset = read_asset(options.input);
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return run_animation(asset, options, seconds).code;
}

}  // namespace elastogen
