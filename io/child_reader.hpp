// SPDX-License-Identifier: Apache-2.0
// Formats whose libraries (assimp, OpenVDB) are not trusted with foreign files. The program
// elastogen-reader reads them in a process of its own, with limits, and answers with a stream of
// bytes (io/asset_stream.hpp).

#pragma once

#include "io/asset.hpp"
#include "io/child_process.hpp"

#include <string>
#include <string_view>

namespace elastogen {

/// "fbx", "vdb" and the other formats that elastogen-reader reads, by their endings.
bool is_child_format(std::string_view format);

/// Reads a file of one of these formats; of a .vdb the grid of that name, or the first. The asset
/// has not been checked, like that of any reader.
/// @throws Error (asset) in a sentence that begins with the path: what the reader refuses, its
///         limits (kReaderMemory, the seconds, the bytes), its crash, an answer that is no asset.
Asset read_in_child(const std::string& path, const std::string& format,
                    const std::string& grid = "", const ChildOptions& options = {});

}  // namespace elastogen
