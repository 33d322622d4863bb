// SPDX-License-Identifier: Apache-2.0
#include "scene/asset_stages.hpp"

#include "core/stopwatch.hpp"
#include "io/read_asset.hpp"
#include "scene/asset_part.hpp"
#include "scene/piece_names.hpp"

#include <algorithm>

namespace elastogen {
namespace {

/// Memory that a voxel filled with eight particles needs [bytes]. Measured 16000 to 17000.
constexpr int64_t kBytesOfParticles = 20'000;

int64_t bytes_of(const ParticleOptions& particles) {
  const int64_t edge = particles.per_edge;
  return kBytesOfParticles * std::max<int64_t>(8, edge * edge * edge) / 8;
}

}  // namespace

Asset run_asset(const RunDescription& run) {
  if (run.shape) return shape_asset(*run.shape);
  ReadOptions read = run.read;
  read.attributes |= asks_for_attributes(run);
  return read_asset(run.input, read);
}

VoxelizeOptions resolution(const RunDescription& run) {
  VoxelizeOptions v;
  v.voxels = run.voxels;
  v.h = run.h;
  v.max_voxels = run.max_voxels;
  v.max_memory = run.max_memory;
  if (method_of(run) == Method::kMpm) v.bytes_per_voxel = bytes_of(run.particles);
  v.part_pieces = run.part_pieces;
  v.thickness = run.thickness;
  return v;
}

AssetSummary summary_of(const Asset& asset, const Body& body, const RunDescription& run) {
  AssetSummary summary;
  summary.path = asset.path;
  summary.format = asset.format;
  summary.vertices = body.carried.rows() - repeated_positions(asset);
  summary.faces = body.is_asset ? body.surface.triangles.rows() : 0;
  const Box& box = body.surface.box;
  const double longest = std::max({box.extent(0), box.extent(1), box.extent(2)});
  summary.size = choose_size(asset, longest, run.size > 0);
  summary.up = choose_up(asset, run.up);
  summary.findings = asset.findings;
  summary.findings.insert(summary.findings.end(), body.findings.begin(), body.findings.end());
  return summary;
}

void take_findings(const Asset& asset, const Voxelized& voxels, Body& body, AssetSummary& summary) {
  body.surface.part = voxels.part;
  summary.closed = voxels.report.closed;
  std::vector<Finding>& findings = summary.findings;
  findings.insert(findings.end(), voxels.report.findings.begin(), voxels.report.findings.end());
  add_joined_pieces(asset, body.surface, voxels.report.gaps, findings);
}

VoxelizedAsset voxelize_asset(const RunDescription& run, RunReport& report) {
  VoxelizedAsset result;
  const Stopwatch watch;
  result.asset = run_asset(run);
  report.stage_seconds.read = watch.seconds();
  result.body = make_body(result.asset, run.size, resolution(run));
  report.asset = summary_of(result.asset, result.body, run);
  if (!report.asset.size.warning.empty()) report.warnings.push_back(report.asset.size.warning);
  VoxelizeOptions voxel_options = resolution(run);
  voxel_options.shell = result.body.shell;
  result.voxels = voxelize(result.body.surface, voxel_options);
  report.stage_seconds.voxelize = watch.seconds() - report.stage_seconds.read;
  take_findings(result.asset, result.voxels, result.body, report.asset);
  report.voxels = result.voxels.grid.voxel_count();
  report.nodes = result.voxels.grid.node_count();
  report.h = result.voxels.grid.h;
  return result;
}

}  // namespace elastogen
