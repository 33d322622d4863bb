// SPDX-License-Identifier: Apache-2.0
#include "cli/exit_code.hpp"
#include "cli/signals.hpp"
#include "cli/verbs.hpp"
#include "network/learn_library.hpp"

#include <fmt/format.h>

#include <cstdio>

namespace elastogen {

int train(const TrainTask& task) {
  TrainMtlTask mtl;
  mtl.law = task.law.c_str(), mtl.poisson = task.poisson;
  mtl.list = task.list.c_str(), mtl.start = task.start.c_str(), mtl.out = task.out.c_str();
  mtl.steps = task.steps, mtl.samples = task.samples;
  mtl.seed = task.seed, mtl.rate = task.rate;
  mtl.device = task.device.c_str();
  mtl.last_layer = task.last_layer, mtl.shared = task.shared ? 1 : 0;
  mtl.resume = task.resume ? 1 : 0;

  watch_signals();
  LearnHooks hooks;
  hooks.say = [&](const std::string& line) {
    if (task.quiet) return;
    fmt::print("{}\n", line);
    std::fflush(stdout);
  };
  hooks.stopped = [] { return pending_signal() != 0; };
  switch (train_mtl(mtl, hooks)) {
    case TrainEnd::kPassing:
      return kExitDone;
    case TrainEnd::kFailing:
      return kExitDraft;
    case TrainEnd::kStopped:
      break;
  }
  return 128 + pending_signal();
}

}  // namespace elastogen
