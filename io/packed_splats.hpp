// SPDX-License-Identifier: Apache-2.0
// PlayCanvas' compressed PLY layout: 16 bytes a splat, in chunks of 256 splats that share the
// ranges of their positions, log scales and colours.

#pragma once

#include "io/asset.hpp"
#include "io/ply_values.hpp"

namespace elastogen {

/// Ranges of one chunk: position, log scale, colour.
struct SplatChunk {
  double low[9] = {};
  double high[9] = {0, 0, 0, 0, 0, 0, 1, 1, 1};
};

/// Whether the vertices have packed positions.
bool is_packed(const PlyElement& vertex);

/// Reads the element chunk. @throws Error (asset) if a range is missing or the file ends early.
std::vector<SplatChunk> read_chunks(const PlyElement& element, PlyValues& values,
                                    const std::string& path);

/// Unpacks the splats: positions and log scales have 11, 10 and 11 bits; rotations 2 (the index of
/// the largest component) and 10, 10, 10 (the others); colours and opacities 8.
/// @throws Error (asset): fewer chunks than the splats need, a property is missing, the file ends
///         early.
SplatCloud read_packed_splats(const PlyElement& vertex, const std::vector<SplatChunk>& chunks,
                              PlyValues& values, const std::string& path);

}  // namespace elastogen
