// SPDX-License-Identifier: Apache-2.0
#include "cli/asset_stages.hpp"

#include "cli/piece_names.hpp"
#include "core/stopwatch.hpp"
#include "io/read_asset.hpp"

#include <algorithm>

namespace elastogen {

VoxelizeOptions resolution(const AnimateOptions& options) {
  VoxelizeOptions v;
  v.voxels = options.voxels;
  v.h = options.h;
  v.max_voxels = options.max_voxels;
  v.max_memory = options.max_memory;
  v.part_pieces = options.part_pieces;
  v.thickness = options.thickness;
  return v;
}

AssetSummary summary_of(const Asset& asset, const Body& body, const AnimateOptions& options) {
  AssetSummary summary;
  summary.path = asset.path;
  summary.format = asset.format;
  summary.vertices = body.carried.rows() - repeated_positions(asset);
  summary.faces = body.is_asset ? body.surface.triangles.rows() : 0;
  const Box& box = body.surface.box;
  const double longest = std::max({box.extent(0), box.extent(1), box.extent(2)});
  summary.size = choose_size(asset, longest, options.size > 0);
  summary.up = choose_up(asset, options.up);
  summary.findings = asset.findings;
  summary.findings.insert(summary.findings.end(), body.findings.begin(), body.findings.end());
  return summary;
}

void take_findings(const Asset& asset, const Voxelized& voxels, Body& body, RunReport& report) {
  body.surface.part = voxels.part;
  report.asset.closed = voxels.report.closed;
  std::vector<Finding>& findings = report.asset.findings;
  findings.insert(findings.end(), voxels.report.findings.begin(), voxels.report.findings.end());
  add_joined_pieces(asset, body.surface, voxels.report.gaps, findings);
}

VoxelizedAsset voxelize_asset(const AnimateOptions& options, RunReport& report) {
  VoxelizedAsset result;
  const Stopwatch watch;
  result.asset = read_asset(options.input, options.read);
  report.stage_seconds.read = watch.seconds();
  result.body = make_body(result.asset, options.size, resolution(options));
  report.asset = summary_of(result.asset, result.body, options);
  if (!report.asset.size.warning.empty()) report.warnings.push_back(report.asset.size.warning);
  VoxelizeOptions voxel_options = resolution(options);
  voxel_options.shell = result.body.shell;
  result.voxels = voxelize(result.body.surface, voxel_options);
  report.stage_seconds.voxelize = watch.seconds() - report.stage_seconds.read;
  take_findings(result.asset, result.voxels, result.body, report);
  report.voxels = result.voxels.grid.voxel_count();
  report.nodes = result.voxels.grid.node_count();
  report.h = result.voxels.grid.h;
  return result;
}

}  // namespace elastogen
