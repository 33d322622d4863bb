// SPDX-License-Identifier: Apache-2.0
// Whether an OpenVDB file is complete. Its reader treats bytes behind the end of a file as zeros.

#pragma once

#include <string>

namespace elastogen {

/// Compares the length of a file with the end that each of its grids states. Files without these
/// numbers (written to a stream, or before version 222 of the format) pass.
/// @throws Error (asset) naming the grid that is cut off.
void check_vdb_is_whole(const std::string& path);

}  // namespace elastogen
