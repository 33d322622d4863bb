// SPDX-License-Identifier: Apache-2.0
// Parts of an asset that the formats of its outputs cannot hold.

#pragma once

#include "io/asset.hpp"

namespace elastogen {

/// Findings on the outputs of a run, before its first step: columns of vertices and normals that a
/// format has no place for, and positions that its float32 numbers would round coarsely.
/// @param paths  of the outputs; their endings tell the formats.
std::vector<Finding> output_findings(const Asset& asset, const Surface& surface,
                                     const std::vector<std::string>& paths);

}  // namespace elastogen
