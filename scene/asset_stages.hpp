// SPDX-License-Identifier: Apache-2.0
// Stages that come before a scene: read, pose, voxelise. Some verbs need only these.

#pragma once

#include "io/report_file.hpp"
#include "scene/description.hpp"
#include "voxelize/body.hpp"
#include "voxelize/voxelize.hpp"

namespace elastogen {

struct VoxelizedAsset {
  Asset asset;
  Body body;
  Voxelized voxels;
};

/// The body of a run: its shape, or the content of its file. @throws Error as read_asset.
Asset run_asset(const RunDescription& run);

/// Resolution and limits of a run, without planes to align with.
VoxelizeOptions resolution(const RunDescription& run);

/// Summary of an asset and its body for a report: counts, findings, size, up.
AssetSummary summary_of(const Asset& asset, const Body& body, const RunDescription& run);

/// Adds the findings of voxelisation to the summary, and stores the parts of the body's triangles.
void take_findings(const Asset& asset, const Voxelized& voxels, Body& body, AssetSummary& summary);

/// Reads and voxelises the input; fills asset, voxels, warnings and times of the report.
/// @throws Error as read_asset and voxelize do.
VoxelizedAsset voxelize_asset(const RunDescription& run, RunReport& report);

}  // namespace elastogen
