// SPDX-License-Identifier: Apache-2.0
// Points that sample the surface of Gaussian splats.

#pragma once

#include "io/asset.hpp"

namespace elastogen {

struct SplatSamples {
  std::vector<Vec3> points;  ///< in the numbers of the splats
  std::vector<Finding> findings;
};

/// Samples the splats that show a surface: opacity above 0.1, all numbers finite, and no axis
/// longer than ten times the median of the longest axes (else it is background or fog; the finding
/// "splats" counts splats that are left out). A splat larger than the spacing of the centres gives
/// points on its two longest axes within one standard deviation, at most 17 x 17.
/// @param place  name of the splats for messages.
/// @param grain  least distance between points of a splat.
/// @throws Error (asset) if no splat shows a surface.
SplatSamples sample_splats(const SplatCloud& splats, const std::string& place, double grain = 0);

/// Box of the visible part of splats: centres and one standard deviation about them, of the splats
/// that sample_splats samples and whose centres lie in the bulk.
/// @param bulk    box of the points without floaters.
/// @param margin  distance by which centres may lie outside the bulk.
Box shown_box(const SplatCloud& splats, const Box& bulk, double margin);

}  // namespace elastogen
