// SPDX-License-Identifier: Apache-2.0
#include "voxelize/voxelize.hpp"

#include "cli/exit_code.hpp"
#include "cli/verbs.hpp"
#include "core/parallel.hpp"
#include "scene/asset_stages.hpp"
#include "scene/version.hpp"
#include "voxelize/vdb_io.hpp"

#include <fmt/format.h>

#include <optional>

namespace elastogen {

int voxelize(const VoxelizeTask& task) {
  const AnimateOptions& o = task.scene;
  // threads and header of the report
  std::optional<ThreadLimit> threads;
  if (o.threads > 0) threads.emplace(o.threads);
  RunReport report;
  report.command = o.command;
  report.commit = build_commit();
  // voxelise, write, report
  const VoxelizedAsset voxelized = voxelize_asset(o, report);
  const VoxelGrid& grid = voxelized.voxels.grid;
  write_vdb(task.output, grid, voxelized.body.surface.box.origin);
  report.peak_memory_bytes = peak_memory_bytes();
  if (!o.report.empty()) write_report(o.report, report);
  // print findings, warnings and counts
  const std::vector<Finding>& findings = report.asset.findings;
  for (const std::string& note : finding_lines(findings, Severity::kNote))
    if (!o.quiet) fmt::print("note: {}\n", note);
  for (const std::string& warning : finding_lines(findings, Severity::kWarning))
    fmt::print(stderr, "warning: {}\n", warning);
  for (const std::string& warning : report.warnings) fmt::print(stderr, "warning: {}\n", warning);
  if (!o.quiet)
    fmt::print("{} voxels of {:.4g} m, {} nodes, {} piece{}, volume {:.6g} m3\nwrote {}\n",
               grid.voxel_count(), grid.h, grid.node_count(), grid.pieces,
               grid.pieces == 1 ? "" : "s",
               grid.volume > 0 ? grid.volume : voxelized.voxels.report.volume, task.output);
  return kExitDone;
}

}  // namespace elastogen
