// SPDX-License-Identifier: Apache-2.0
// Gaussian splats in PLY files: the layout of the 3DGS reference code (Kerbl et al. 2023) and the
// compressed layout of PlayCanvas (chunks of 256 splats, 16 bytes a splat).

#pragma once

#include "io/asset.hpp"
#include "io/ply_values.hpp"
#include "io/read_options.hpp"

namespace elastogen {

/// The vertices have a column scale_*, rot_* or f_dc_* (a file that lacks others of them is refused
/// by read_splats, not read as points), or packed_position behind an element chunk.
bool is_splats(const PlyHeader& header);

/// Reads the splats of such a file; quaternions are as the file has them, the check makes them
/// unit. A compressed file's harmonics beyond the first are left out with a finding in the asset.
///
/// Colours red, green, blue stand in for missing f_dc_* (finding splat-colours), opacity 1 for a
/// missing one (splat-opacity). Other columns are carried (carried-columns). Sizes and opacities
/// are taken as they are, without exponential and logistic function (linear-splats), if
///
/// - no size is negative and some are positive, all opacities that there are lie within 0 ... 1,
///   and
/// - the median of the longest axes is nearer (as a ratio) to edge / sqrt(splats), the spacing on a
///   surface as wide as all but 2 % of the splats on each side, than that of their exponentials.
///
/// @throws Error (asset): a property is missing (named), the f_rest properties are not 0, 9, 24 or
///         45, chunks are missing or stand behind the splats, the file ends early.
SplatCloud read_splats(const PlyHeader& header, PlyValues& values, SplatScales scales,
                       Asset& asset);

}  // namespace elastogen
