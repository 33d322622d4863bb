// SPDX-License-Identifier: Apache-2.0
// Formats whose readers are libraries that we do not trust with foreign files (assimp, OpenVDB):
// the program elastogen-reader reads them in a process of its own, with limits, and answers with a
// stream of bytes (io/asset_stream.hpp).

#pragma once

#include "io/asset.hpp"

#include <string>
#include <string_view>

namespace elastogen {

inline constexpr int64_t kReaderMemory = int64_t{1}
                                         << 30;  ///< address space of the process [bytes]
inline constexpr int kReaderSeconds = 10;        ///< CPU time, and wall time

struct ChildOptions {
  std::string program;              ///< the reader; empty: find_reader()
  double seconds = kReaderSeconds;  ///< wall time after which the process is killed
  int64_t max_bytes = 1 << 28;      ///< of the answer
};

/// "fbx", "vdb" and the other formats that elastogen-reader reads, by their endings.
bool is_child_format(std::string_view format);

/// The program elastogen-reader: beside the running program, else what the environment variable
/// ELASTOGEN_READER names, else where it was installed.
/// @throws Error (asset) if it is at none of these places, saying so.
std::string find_reader();

/// Reads a file of one of these formats. The asset is as unchecked as that of any reader.
/// @throws Error (asset) in a sentence that begins with the path: what the reader refuses, its
///         limits (kReaderMemory, the seconds, the bytes), its crash, an answer that is no asset.
Asset read_in_child(const std::string& path, const std::string& format,
                    const ChildOptions& options = {});

}  // namespace elastogen
