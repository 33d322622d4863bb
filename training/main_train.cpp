// SPDX-License-Identifier: Apache-2.0
// elastogen-train: the trainer without the rest of the project, for machines that have libtorch and
// little else. The options are those of `elastogen train mtl`.

#include "core/error.hpp"
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

TrainMtl task_of(int argc, char** argv) {
  TrainMtl task;
  for (int k = 1; k < argc; ++k) {
    const std::string option = argv[k];
    if (option == "--resume" || option == "--shared-hidden") {
      (option == "--resume" ? task.fit.resume : task.fit.shared) = true;
      continue;
    }
    ELASTOGEN_CHECK(k + 1 < argc, option, " needs a value");
    set(task, option, argv[++k]);
  }
  return task;
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
    const TrainEnd end = train_mtl(task_of(argc, argv), hooks);
    return end == TrainEnd::kPassing ? 0 : end == TrainEnd::kFailing ? 4 : 130;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "elastogen-train: %s\n", error.what());
    return 1;
  }
}
