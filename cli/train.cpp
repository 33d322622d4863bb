// SPDX-License-Identifier: Apache-2.0
#include "cli/exit_code.hpp"
#include "cli/signals.hpp"
#include "cli/verbs.hpp"
#include "cli/weights.hpp"
#include "core/error.hpp"
#include "core/tensor_file.hpp"
#include "diffusion/make_dataset.hpp"
#include "io/safe_file.hpp"
#include "network/law/learn_library.hpp"
#include "training/hidden_layers.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>

namespace elastogen {
namespace {

LearnHooks hooks_of(bool quiet) {
  LearnHooks hooks;
  hooks.say = [quiet](const std::string& line) {
    if (quiet) return;
    fmt::print("{}\n", line);
    std::fflush(stdout);
  };
  hooks.stopped = [] { return pending_signal() != 0; };
  return hooks;
}

int code_of(TrainEnd end) {
  switch (end) {
    case TrainEnd::kPassing:
      return kExitDone;
    case TrainEnd::kFailing:
      return kExitDraft;
    case TrainEnd::kStopped:
      break;
  }
  return 128 + pending_signal();
}

TrainEnd run(const TrainTask& task) {
  TrainMtlTask mtl;
  mtl.law = task.law.c_str(), mtl.poisson = task.poisson;
  mtl.list = task.list.c_str(), mtl.start = task.start.c_str(), mtl.out = task.out.c_str();
  mtl.steps = task.steps, mtl.samples = task.samples;
  mtl.seed = task.seed, mtl.rate = task.rate;
  mtl.device = task.device.c_str();
  mtl.last_layer = task.last_layer, mtl.shared = task.shared ? 1 : 0;
  mtl.resume = task.resume ? 1 : 0;
  return train_mtl(mtl, hooks_of(task.quiet));
}

TrainEnd run(const GeneratorTask& task) {
  TrainGeneratorTask generator;
  generator.dataset = task.dataset.c_str(), generator.autoencoder = task.autoencoder.c_str();
  generator.out = task.out.c_str();
  generator.size = task.size.c_str(), generator.layers = task.layers.c_str();
  generator.device = task.device.c_str();
  generator.components = task.components;
  generator.steps = task.steps, generator.batch = task.batch;
  generator.seed = task.seed, generator.rate = task.rate;
  generator.resume = task.resume ? 1 : 0;
  return task.diffusion ? train_diffusion(generator, hooks_of(task.quiet))
                        : train_autoencoder(generator, hooks_of(task.quiet));
}

/// Makes a dataset; needs no libtorch.
TrainEnd run(const DatasetTask& task) {
  // the hidden layers that all materials share
  const std::string path = task.hidden.empty() ? find_weight_file(kHiddenLayers) : task.hidden;
  ELASTOGEN_CHECK(!path.empty(), "there is no ", kHiddenLayers, " in ",
                  fmt::format("{}", fmt::join(weight_folders(), ", ")),
                  "; name hidden layers (--hidden)");
  const TensorFile hidden = decode_tensors(read_file(path, 1 << 24), path);
  // fit material after material; a part file lets a stopped run go on
  const LearnHooks learn = hooks_of(task.quiet);
  FitHooks hooks;
  hooks.say = learn.say, hooks.stopped = learn.stopped;
  MakeDatasetOptions options;
  options.count = task.count, options.seed = task.seed;
  options.iterations = task.iterations;
  options.resume = task.resume;
  options.checkpoint = task.out + ".part";
  const MadeDataset made =
      make_dataset(hidden.get("neural_mtl", {kMtlParameters}).values, options, hooks);
  // write the dataset and drop the part file
  if (made.data.count() == 0) {
    hooks.say(fmt::format("stopped after {} fits; --resume goes on", made.fits));
    return TrainEnd::kStopped;
  }
  write_file(task.out, encode_dataset(made.data));
  std::error_code ignored;
  std::filesystem::remove(options.checkpoint, ignored);
  return TrainEnd::kPassing;
}

}  // namespace

int train(const TrainVerb& task) {
  watch_signals();
  return code_of(std::visit([](const auto& one) { return run(one); }, task));
}

}  // namespace elastogen
