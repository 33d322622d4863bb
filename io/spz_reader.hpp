// SPDX-License-Identifier: Apache-2.0
// Gaussian splats in the SPZ layout (Niantic, versions 2 to 4) to an Asset.

#pragma once

#include "io/asset.hpp"

#include <string_view>

namespace elastogen {

/// Versions 2 and 3: gzip of a header and of the attributes, one after the other: positions of 24
/// bits with a binary point, opacities, colours, log scales, rotations, harmonics. Extensions
/// behind them are skipped. Version 4: a plain header, extensions, a table, a Zstandard stream for
/// each attribute.
/// @throws Error (asset) with the file: no gzip, a damaged one or stream, another version or
///         degree, fewer bytes than the header's count needs, a count that the file could not
///         unpack to.
Asset read_spz(const std::string& path);

/// Reads SPZ from memory; `path` is for messages.
Asset parse_spz(std::string_view bytes, const std::string& path);

}  // namespace elastogen
