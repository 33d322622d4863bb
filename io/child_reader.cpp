// SPDX-License-Identifier: Apache-2.0
#include "io/child_reader.hpp"

#include "core/error.hpp"
#include "io/asset_stream.hpp"

#include <algorithm>

namespace elastogen {

bool is_child_format(std::string_view format) {
  static constexpr std::string_view kFormats[] = {"fbx", "dae", "3ds", "x", "ac", "vdb"};
  return std::ranges::find(kFormats, format) != std::end(kFormats);
}

Asset read_in_child(const std::string& path, const std::string& format, const std::string& grid,
                    const ChildOptions& options) {
  std::string bytes;
  try {
    bytes =
        answer_of_reader({grid.empty() ? format : concat(format, ':', grid), path}, -1, options);
  } catch (const Error& error) {
    throw Error(path + ": " + error.what(), error.kind());
  }
  Asset asset = decode_asset(bytes, path);
  asset.format = format;
  return asset;
}

}  // namespace elastogen
