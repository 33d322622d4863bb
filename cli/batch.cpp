// SPDX-License-Identifier: Apache-2.0
// Runs scenes side by side, each on a thread of its own. The threads share what is defined here:
// the next scene, the sums of the summary, and the two streams to which they print.
#include "cli/run.hpp"
#include "cli/signals.hpp"
#include "cli/typed.hpp"
#include "cli/verbs.hpp"
#include "core/cuda/card.hpp"
#include "core/parallel.hpp"
#include "core/stopwatch.hpp"
#include "scene/asset_stages.hpp"

#include <fmt/format.h>

#include <atomic>
#include <cmath>
#include <mutex>
#include <thread>

namespace elastogen {
namespace {

constexpr size_t kJobsOnCard = 8;
constexpr int kNotRun = -1;

/// A scene as `animate --scene FILE` resolves it, or why it cannot be run.
struct BatchScene {
  std::string file;
  AnimateOptions options;
  std::optional<Error> error;
};

BatchScene resolved(const BatchTask& task, const std::string& file) {
  std::vector<const char*> argv = {"elastogen"};
  for (const std::string& word : task.words) argv.push_back(word.c_str());
  argv.insert(argv.begin() + 2, {"--scene", file.c_str()});  // after the verb
  BatchScene scene{file, {}, {}};
  try {
    scene.options = parse_command_line(int(argv.size()), argv.data()).animate.value();
    scene.options.quiet = true;
  } catch (const Error& error) {
    scene.error = error;
  }
  return scene;
}

/// Adds the scene's name to a message, unless it begins with that already.
std::string of_scene(const std::string& file, const std::string& text) {
  return text.starts_with(file + ':') ? text : file + ": " + text;
}

class Batch {
 public:
  Batch(const std::vector<BatchScene>& scenes, bool quiet)
      : scenes_(scenes), quiet_(quiet), codes_(scenes.size(), kNotRun) {}

  /// Runs the scenes on `jobs` threads. @return the exit code.
  int run(size_t jobs) {
    const Stopwatch watch;
    {
      std::vector<std::jthread> threads;
      for (size_t k = 0; k < jobs; ++k) threads.emplace_back([this] { work(); });
    }
    if (!quiet_) print_summary(watch.seconds());
    return code();
  }

 private:
  /// Runs one scene after the other until there is none left or a signal comes.
  void work() {
    for (size_t k; pending_signal() == 0 && (k = next_++) < scenes_.size();) {
      const BatchScene& scene = scenes_[k];
      codes_[k] = exit_code_of([&] { return run_scene(scene); },
                               [&](const char* text) { say_error(scene, text); });
    }
  }

  int run_scene(const BatchScene& scene) {
    if (scene.error) throw *scene.error;
    const Stopwatch watch;
    const Asset asset = run_asset(scene.options);
    RunHooks hooks;
    hooks.on_warning = [&](const std::string& text) {
      const std::lock_guard lock(mutex_);
      fmt::print(stderr, "warning: {}\n", of_scene(scene.file, text));
    };
    const CommandResult result = run_animation(asset, scene.options, watch.seconds(), hooks);
    take(scene, result.report, watch.seconds());
    return result.code;
  }

  void take(const BatchScene& scene, const RunReport& r, double seconds) {
    const std::lock_guard lock(mutex_);
    ++ended_, ++written_;
    voxel_steps_ += double(r.voxels) * double(r.steps);
    if (quiet_) return;
    fmt::print("{}/{} {}: {} frames, {}, worst residual {:.2e}, {:.2f} s\n", ended_, scenes_.size(),
               scene.file, r.frames, step_counts(r), r.worst_residual, seconds);
    std::fflush(stdout);
  }

  void say_error(const BatchScene& scene, const char* text) {
    const std::lock_guard lock(mutex_);
    ++ended_;
    fmt::print(stderr, "elastogen: {}\n", of_scene(scene.file, text));
  }

  void print_summary(double seconds) const {
    fmt::print("{} of {} scenes in {:.2f} s: {:.3g} scenes a second, {:.3g} voxel-steps a second\n",
               written_, scenes_.size(), seconds, double(written_) / seconds,
               voxel_steps_ / seconds);
  }

  /// The code of a signal that left scenes unfinished, else of the first scene that failed.
  int code() const {
    const int signal = pending_signal();
    for (const int code : codes_)
      if (signal != 0 && (code == kNotRun || code == 128 + signal)) return 128 + signal;
    for (const int code : codes_)
      if (code != kExitDone) return code;
    return kExitDone;
  }

  const std::vector<BatchScene>& scenes_;
  const bool quiet_;
  std::atomic<size_t> next_ = 0;
  std::vector<int> codes_;  ///< of the scenes; each written by the thread that runs it
  std::mutex mutex_;        ///< guards printing and all members below
  size_t ended_ = 0, written_ = 0;
  double voxel_steps_ = 0;
};

/// Whether some steps may run on a card.
bool may_use_card(const std::vector<BatchScene>& scenes) {
  const auto may = [](const BatchScene& scene) {
    return !scene.error && scene.options.solver.device != Device::kCpu;
  };
  return std::any_of(scenes.begin(), scenes.end(), may) && cuda::has_device();
}

}  // namespace

int animate_batch(const BatchTask& task) {
  std::vector<BatchScene> scenes;
  for (const std::string& file : task.files) scenes.push_back(resolved(task, file));
  std::vector<NamedScene> named;
  for (const BatchScene& scene : scenes)
    if (!scene.error) named.push_back({scene.file, scene.options});
  check_outputs(named);

  watch_signals();
  const bool card = may_use_card(scenes);
  // on the CPU a scene stays on its thread, as there are enough scenes for all cores
  std::optional<ThreadLimit> limit;
  if (!card) {
    limit.emplace(1);
    for (BatchScene& scene : scenes) scene.options.threads = 1;
  }
  const size_t cores = std::max(1U, std::thread::hardware_concurrency());
  const size_t jobs = task.jobs > 0 ? size_t(task.jobs) : card ? kJobsOnCard : cores;
  return Batch(scenes, task.quiet).run(std::min(jobs, scenes.size()));
}

}  // namespace elastogen
