// SPDX-License-Identifier: Apache-2.0
#include "io/read_asset.hpp"

#include "io/asset_check.hpp"
#include "io/byte_reader.hpp"
#include "io/child_reader.hpp"
#include "io/gltf_reader.hpp"
#include "io/obj_reader.hpp"
#include "io/ply_reader.hpp"
#include "io/safe_file.hpp"
#include "io/stl_reader.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>

namespace elastogen {
namespace {

constexpr size_t kHeadBytes = 512;  ///< enough for every signature

/// The first bytes of a file. @throws Error (asset) if there are none.
std::string head_of(const std::string& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  ELASTOGEN_CHECK_ASSET(std::filesystem::exists(status), path, ": there is no such file");
  ELASTOGEN_CHECK_ASSET(!std::filesystem::is_directory(status), path, ": is a folder, not a file");
  ELASTOGEN_CHECK_ASSET(std::filesystem::is_regular_file(status), path, ": is not a regular file");
  std::ifstream file(path, std::ios::binary);
  ELASTOGEN_CHECK_ASSET(file.is_open(), path, ": cannot be opened");
  std::string head(kHeadBytes, '\0');
  file.read(head.data(), kHeadBytes);
  head.resize(size_t(file.gcount()));
  ELASTOGEN_CHECK_ASSET(!head.empty(), path, ": the file is empty");
  return head;
}

/// Lower-case ending of a file name without its dot.
std::string ending_of(const std::string& path) {
  std::string ending = std::filesystem::path(path).extension().string();
  if (!ending.empty()) ending.erase(0, 1);
  for (char& c : ending) c = c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c;
  return ending;
}

/// Name of the format that the first bytes prove, "" if they prove none.
std::string format_of(std::string_view head) {
  struct Signature {
    std::string_view bytes, format;
  };
  using namespace std::string_view_literals;
  static constexpr Signature kSignatures[] = {
      {"glTF", "glb"},        {"ply\n", "ply"},     {"ply\r", "ply"},     {"Kaydara FBX", "fbx"},
      {"; FBX", "fbx"},       {" BDV"sv, "vdb"},    {"PXR-USDC", "usdc"}, {"#usda", "usda"},
      {"PK\x03\x04", "zip"},  {"\x1f\x8b", "gzip"}, {"LASF", "las"},      {"OFF", "off"},
      {"$MeshFormat", "msh"}, {"xof ", "x"},        {"# .PCD", "pcd"},    {"# vtk DataFile", "vtk"},
      {"\x89HDF", "hdf5"},    {"\x89PNG", "png"},
  };
  head = without_mark(head);
  for (const Signature& s : kSignatures)
    if (head.starts_with(s.bytes)) return std::string(s.format);
  return "";
}

}  // namespace

Asset read_asset(const std::string& path) {
  const std::string head = head_of(path);
  const std::string proven = format_of(head), ending = ending_of(path);
  const std::string format = proven.empty() ? ending : proven;

  Asset asset;
  if (format == "obj") {
    asset = read_obj(path);
  } else if (format == "ply") {
    asset = read_ply(path);
  } else if (format == "stl" || (format != "gltf" && head.starts_with("solid"))) {
    asset = read_stl(path);
  } else if (format == "gltf" || format == "glb") {
    asset = read_gltf(path);
  } else if (is_child_format(format)) {
    asset = read_in_child(path, format);
  } else {
    throw Error(
        concat(path, ": ", format.empty() ? "this format" : format,
               " is not read; read are .obj .ply .stl .glb .gltf .fbx .dae .3ds .x .ac .vdb"),
        ErrorKind::kAsset);
  }
  check_asset(asset);
  return asset;
}

}  // namespace elastogen
