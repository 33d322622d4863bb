// SPDX-License-Identifier: Apache-2.0
// An asset of meshes as one flat stream of bytes: what the reader process answers on its pipe. It
// is not trusted: every count is compared with the bytes that follow it.

#pragma once

#include "io/asset.hpp"

#include <string>
#include <string_view>

namespace elastogen {

/// Why the reader process has no asset.
enum class ReaderFailure : uint8_t {
  kRefused = 1,  ///< the message says what is wrong with the file
  kMemory = 2,   ///< its limit of memory was reached
};

/// The stream of an asset: meshes, nodes, materials (textures as the file names them), findings,
/// up and unit.
std::string encode_asset(const Asset& asset);

/// The stream of a failure.
std::string encode_failure(ReaderFailure failure, std::string_view message);

/// The asset of a stream, its path set to `path`; textures are resolved beside it, those that are
/// not beneath its folder are dropped with a finding. Indices are left to check_asset.
/// @throws Error (asset): the failure that was encoded, in a sentence that begins with the path; a
///         stream that is too short, too long or no stream.
Asset decode_asset(std::string_view bytes, const std::string& path);

}  // namespace elastogen
