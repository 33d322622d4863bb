// SPDX-License-Identifier: Apache-2.0
// The stages before a scene, for the verbs that end there: read, pose, voxelise.

#pragma once

#include "cli/options.hpp"
#include "io/report_file.hpp"
#include "voxelize/body.hpp"
#include "voxelize/voxelize.hpp"

namespace elastogen {

struct VoxelizedAsset {
  Asset asset;
  Body body;
  Voxelized voxels;
};

/// Resolution and limits of a run, without planes to align with.
VoxelizeOptions resolution(const AnimateOptions& options);

/// What the report says of an asset and its body: counts, findings, size, up.
AssetSummary summary_of(const Asset& asset, const Body& body, const AnimateOptions& options);

/// Adds what voxelising found to the asset's part of the report, and marks the body's parts.
void take_findings(const Asset& asset, const Voxelized& voxels, Body& body, RunReport& report);

/// Reads and voxelises the input; fills asset, voxels, warnings and times of the report.
/// @throws Error as read_asset and voxelize do.
VoxelizedAsset voxelize_asset(const AnimateOptions& options, RunReport& report);

}  // namespace elastogen
