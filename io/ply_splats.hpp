// SPDX-License-Identifier: Apache-2.0
// Gaussian splats in PLY files: the layout of the 3DGS reference code (Kerbl et al. 2023) and the
// compressed layout of PlayCanvas (chunks of 256 splats, 16 bytes a splat).

#pragma once

#include "io/asset.hpp"
#include "io/ply_values.hpp"

namespace elastogen {

/// The vertices have f_dc_0, opacity, scale_0, rot_0, or packed_position behind an element chunk.
bool is_splats(const PlyHeader& header);

/// Reads the splats of such a file; quaternions are as the file has them, the check makes them
/// unit. A compressed file's harmonics beyond the first are left out with a finding in the asset.
/// @throws Error (asset): a property is missing, the f_rest properties are not 0, 9, 24 or 45,
///         chunks are missing or stand behind the splats, the file ends early.
SplatCloud read_splats(const PlyHeader& header, PlyValues& values, Asset& asset);

}  // namespace elastogen
