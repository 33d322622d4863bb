// SPDX-License-Identifier: Apache-2.0
#include "cli/exit_code.hpp"
#include "cli/particle_study.hpp"
#include "cli/signals.hpp"
#include "cli/study_runs.hpp"
#include "cli/verbs.hpp"
#include "core/error.hpp"
#include "core/parallel.hpp"
#include "io/study_page.hpp"
#include "io/study_writer.hpp"

#include <fmt/format.h>

#include <filesystem>

namespace elastogen {
namespace {

/// Prints a line for each run.
void print(const StudyResult& result) {
  for (const StudyRun& run : result.runs) {
    fmt::print("{:24} {:10.2f} ms a step", run.name, run.step_ms.median);
    if (run.solver_error)
      fmt::print("   solver {:.2e} a step, {:.2e} free", run.solver_error->step.max,
                 run.solver_error->free_run.max);
    if (run.discretisation_error)
      fmt::print("   grid {:.2e} (reference's own change {:.2e})",
                 run.discretisation_error->free_run.max,
                 run.discretisation_error->reference_change.value_or(0));
    fmt::print("\n");
  }
}

}  // namespace

int study(const StudyTask& task) {
  watch_signals();
  std::optional<ThreadLimit> threads;
  if (task.scene.threads > 0) threads.emplace(task.scene.threads);
  std::error_code error;
  std::filesystem::create_directories(task.folder, error);
  ELASTOGEN_CHECK(!error, task.folder, ": cannot be made a folder: ", error.message());
  if (method_of(task.scene) == Method::kMpm) {
    const ParticleStudyResult particles = particle_study(task);
    write_particle_study(task.folder, particles);
    if (!task.scene.quiet) print_particle_study(particles);
    return pending_signal() != 0 ? 128 + pending_signal() : kExitDone;
  }
  const StudyResult result = Study(task).run();
  write_study_json(task.folder + "/study.json", result);
  write_study_csv(task.folder + "/study.csv", result);
  write_study_page(task.folder + "/study.html", result);
  if (!task.scene.quiet) print(result);
  const int signal = pending_signal();
  return signal != 0 ? 128 + signal : kExitDone;
}

}  // namespace elastogen
