// SPDX-License-Identifier: Apache-2.0
#include "scene/run.hpp"

#include "core/parallel.hpp"
#include "core/stopwatch.hpp"
#include "io/safe_file.hpp"
#include "scene/asset_stages.hpp"
#include "scene/particle_setup.hpp"
#include "scene/tet_asset.hpp"
#include "scene/version.hpp"

#include <optional>

namespace elastogen {

RunResult run_scene(const RunDescription& run, const ClipHooks& hooks) {
  std::optional<ThreadLimit> threads;
  if (run.threads > 0) threads.emplace(run.threads);
  RunResult result;
  RunReport& report = result.report;
  report.command = run.command;
  report.commit = build_commit();

  const Stopwatch watch;
  const bool tets = run.fem && is_tet_file(run.input);
  const TetAsset of_tets = tets ? read_tet_asset(run.input) : TetAsset();
  const Asset asset = tets ? of_tets.asset : run_asset(run);
  report.stage_seconds.read = watch.seconds();
  const Setup setup = tets ? set_up(of_tets, run) : set_up(asset, run);
  add_summary(setup, report);

  if (!run.report.empty()) SafeFile probe(run.report);  // throws now if it cannot be written
  result.end = play_clip(shown_asset(asset, setup), setup, run, hooks, report);
  report.peak_memory_bytes = peak_memory_bytes();
  if (!run.report.empty()) write_report(run.report, report);
  return result;
}

}  // namespace elastogen
