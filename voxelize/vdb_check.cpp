// SPDX-License-Identifier: Apache-2.0
#include "voxelize/vdb_check.hpp"

#include "core/error.hpp"

#include <openvdb/io/GridDescriptor.h>
#include <openvdb/io/io.h>
#include <openvdb/openvdb.h>

#include <filesystem>
#include <fstream>

namespace elastogen {
namespace {

constexpr uint32_t kFirstVersion = 222;  // version from which on the layout below holds
constexpr int kIdBytes = 36;

template <class T>
T next(std::istream& file) {
  T value = {};
  file.read(reinterpret_cast<char*>(&value), sizeof value);
  return value;
}

}  // namespace

void check_vdb_is_whole(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const auto bytes = int64_t(std::filesystem::file_size(path));
  next<int64_t>(file);  // magic number
  const auto version = next<uint32_t>(file);
  if (version < kFirstVersion) return;
  const auto major = next<uint32_t>(file), minor = next<uint32_t>(file);
  if (next<char>(file) == 0) return;  // no grid states its end
  openvdb::io::setVersion(file, {major, minor}, version);
  file.seekg(kIdBytes, std::ios::cur);
  openvdb::MetaMap().readMeta(file);
  const auto grids = next<int32_t>(file);
  ELASTOGEN_CHECK_ASSET(file.good(), "the file is cut off in its header");
  for (int32_t g = 0; g < grids; ++g) {
    openvdb::io::GridDescriptor grid;
    grid.read(file);
    ELASTOGEN_CHECK_ASSET(file.good() && grid.getEndPos() <= bytes, "the file is cut off: grid ",
                          g + 1, " of ", grids, " ends at byte ", grid.getEndPos(),
                          ", the file at ", bytes);
    grid.seekToEnd(file);
  }
}

}  // namespace elastogen
