// SPDX-License-Identifier: Apache-2.0
// elastogen-train: the trainer without the rest of the project, for machines with libtorch and
// little else. It has the options of `elastogen train`:
//
//   elastogen-train [mtl] OPTIONS
//   elastogen-train autoencoder|diffusion DATASET OPTIONS

#include "core/error.hpp"
#include "diffusion/train_generator.hpp"
#include "training/train_mtl.hpp"

#include <charconv>
#include <csignal>
#include <cstdio>
#include <exception>
#include <map>

namespace {

using namespace elastogen;

volatile std::sig_atomic_t g_stop = 0;

template <class Number>
void read(const std::string& text, Number& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  ELASTOGEN_CHECK(error == std::errc() && end == text.data() + text.size(), "'", text,
                  "' is not a number");
}

void set(TrainMtl& task, const std::string& option, const std::string& text) {
  if (option == "--law") return void(task.law = text);
  if (option == "--poisson") return read(text, task.poisson);
  if (option == "--start") return void(task.start = text);
  if (option == "--list") return void(task.list = text);
  if (option == "--out") return void(task.out = text);
  if (option == "--steps") return read(text, task.fit.steps);
  if (option == "--samples") return read(text, task.fit.samples);
  if (option == "--seed") return read(text, task.fit.seed);
  if (option == "--rate") return read(text, task.fit.rate);
  if (option == "--last-layer") return read(text, task.last_layer);
  if (option == "--device") return void(task.fit.device = text);
  throw Error(concat("unknown option '", option, "'"));
}

bool set_flag(TrainMtl& task, const std::string& option) {
  if (option == "--resume") return task.fit.resume = true;
  return option == "--shared-hidden" && (task.fit.shared = true);
}

void set(TrainGenerator& task, const std::string& option, const std::string& text) {
  if (option == "--autoencoder") return void(task.autoencoder = text);
  if (option == "--out") return void(task.out = text);
  if (option == "--size") return void(task.size = text);
  if (option == "--layers") return void(task.layers = text);
  if (option == "--components") return read(text, task.components);
  if (option == "--steps") return read(text, task.steps);
  if (option == "--batch") return read(text, task.batch);
  if (option == "--seed") return read(text, task.seed);
  if (option == "--rate") return read(text, task.rate);
  if (option == "--device") return void(task.device = text);
  throw Error(concat("unknown option '", option, "'"));
}

bool set_flag(TrainGenerator& task, const std::string& option) {
  return option == "--resume" && (task.resume = true);
}

/// Reads the options from argument `first` on.
template <class Task>
Task task_of(Task task, int first, int argc, char** argv) {
  for (int k = first; k < argc; ++k) {
    const std::string option = argv[k];
    if (set_flag(task, option)) continue;
    ELASTOGEN_CHECK(k + 1 < argc, option, " needs a value");
    set(task, option, argv[++k]);
  }
  return task;
}

TrainEnd run(int argc, char** argv, const FitHooks& hooks) {
  const std::string verb = argc > 1 ? argv[1] : "";
  if (verb == "autoencoder" || verb == "diffusion") {
    ELASTOGEN_CHECK(argc > 2, verb, " needs a dataset");
    TrainGenerator task;
    task.dataset = argv[2];
    if (verb == "autoencoder") {
      task.steps = 20000, task.batch = 256, task.rate = 1e-4;
      return train_autoencoder(task_of(task, 3, argc, argv), hooks);
    }
    task.steps = 60000, task.batch = 512, task.rate = 1e-3;
    return train_diffusion(task_of(task, 3, argc, argv), hooks);
  }
  return train_mtl(task_of(TrainMtl{}, verb == "mtl" ? 2 : 1, argc, argv), hooks);
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGINT, [](int) { g_stop = 1; });
  std::signal(SIGTERM, [](int) { g_stop = 1; });
  try {
    FitHooks hooks;
    hooks.say = [](const std::string& line) {
      std::printf("%s\n", line.c_str());
      std::fflush(stdout);
    };
    hooks.stopped = [] { return g_stop != 0; };
    const TrainEnd end = run(argc, argv, hooks);
    return end == TrainEnd::kPassing ? 0 : end == TrainEnd::kFailing ? 4 : 130;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "elastogen-train: %s\n", error.what());
    return 1;
  }
}
