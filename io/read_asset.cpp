// SPDX-License-Identifier: Apache-2.0
#include "io/read_asset.hpp"

#include "io/asset_check.hpp"
#include "io/byte_reader.hpp"
#include "io/child_reader.hpp"
#include "io/gltf_reader.hpp"
#include "io/las_reader.hpp"
#include "io/obj_reader.hpp"
#include "io/off_reader.hpp"
#include "io/pcd_reader.hpp"
#include "io/ply_reader.hpp"
#include "io/safe_file.hpp"
#include "io/splat_reader.hpp"
#include "io/spz_reader.hpp"
#include "io/stl_reader.hpp"
#include "io/xyz_reader.hpp"

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

/// Name of the format that the first bytes prove, "" if they prove no format.
std::string format_of(std::string_view head) {
  struct Signature {
    std::string_view bytes, format;
  };
  using namespace std::string_view_literals;
  static constexpr Signature kSignatures[] = {
      {"glTF", "glb"},        {"ply\n", "ply"},     {"ply\r", "ply"},     {"Kaydara FBX", "fbx"},
      {"; FBX", "fbx"},       {" BDV"sv, "vdb"},    {"PXR-USDC", "usdc"}, {"#usda", "usda"},
      {"PK\x03\x04", "zip"},  {"\x1f\x8b", "gzip"}, {"LASF", "las"},      {"OFF", "off"},
      {"COFF", "off"},        {"NOFF", "off"},      {"STOFF", "off"},     {"NGSP", "spz"},
      {"$MeshFormat", "msh"}, {"xof ", "x"},        {"# .PCD", "pcd"},    {"# vtk DataFile", "vtk"},
      {"\x89HDF", "hdf5"},    {"\x89PNG", "png"},
  };
  head = without_mark(head);
  for (const Signature& s : kSignatures)
    if (head.starts_with(s.bytes)) return std::string(s.format);
  return "";
}

struct Reader {
  std::string_view format;
  Asset (*read)(const std::string& path);
};

constexpr Reader kReaders[] = {
    {"obj", read_obj},   {"ply", read_ply},  {"stl", read_stl}, {"glb", read_gltf},
    {"gltf", read_gltf}, {"off", read_off},  {"xyz", read_xyz}, {"asc", read_xyz},
    {"pts", read_xyz},   {"pcd", read_pcd},  {"las", read_las}, {"splat", read_splat},
    {"spz", read_spz},   {"gzip", read_spz},
};

/// Advice on formats that are not read, by their ending.
struct Advice {
  std::string_view format, text;
};

constexpr std::string_view kSplatAdvice =
    "SuperSplat and splat-transform turn it into a .ply of splats; ";
constexpr std::string_view kSceneAdvice = "Blender exports it as .glb; ";
constexpr std::string_view kTetAdvice =
    "simulate takes its tetrahedra, Gmsh and meshio turn its surface into .stl; ";
constexpr std::string_view kSolidAdvice = "its program exports it as .stl or .obj; ";
constexpr Advice kAdvice[] = {
    {"ksplat", kSplatAdvice},
    {"sog", kSplatAdvice},
    {"sogs", kSplatAdvice},
    {"rad", kSplatAdvice},
    {"laz", "laszip and las2las turn it into .las; "},
    {"e57", "CloudCompare and PDAL turn it into .las or .ply; "},
    {"usda", kSceneAdvice},
    {"usdc", kSceneAdvice},
    {"usdz", kSceneAdvice},
    {"blend", kSceneAdvice},
    {"abc", kSceneAdvice},
    {"msh", kTetAdvice},
    {"vtk", kTetAdvice},
    {"vtu", kTetAdvice},
    {"step", kSolidAdvice},
    {"stp", kSolidAdvice},
    {"iges", kSolidAdvice},
    {"3mf", kSolidAdvice},
};

/// The asset of a file whose format is known; `reader` is null for the formats of the child.
Asset read_format(const std::string& path, const std::string& format, const Reader* reader,
                  const ReadOptions& options) {
  ELASTOGEN_CHECK_ASSET(options.grid.empty() || format == "vdb", path, ": the grid \"",
                        options.grid, "\" is asked for, which only .vdb files have");
  if (!reader) return read_in_child(path, format, options.grid);
  if (reader->format == "ply") return read_ply(path, options);
  if (reader->format == "glb" || reader->format == "gltf") return read_gltf(path, options);
  return reader->read(path);
}

}  // namespace

Asset read_asset(const std::string& path, const ReadOptions& options) {
  const std::string head = head_of(path);
  const std::string proven = format_of(head), ending = ending_of(path);
  const std::string format = proven.empty() ? ending : proven;

  // formats that are always text, or may be
  static constexpr std::string_view kTexts[] = {"obj", "ply", "stl", "off",
                                                "xyz", "asc", "pts", "pcd"};
  ELASTOGEN_CHECK_ASSET(!is_utf16(head) || std::ranges::find(kTexts, format) == std::end(kTexts),
                        path, ": is UTF-16 text: save it as UTF-8");
  const auto named = [](const std::string& name) {
    return [&](const auto& entry) { return entry.format == name; };
  };
  auto reader = std::ranges::find_if(kReaders, named(format));
  if (format != "gltf" && head.starts_with("solid"))
    reader = std::ranges::find_if(kReaders, named("stl"));
  const bool child = reader == std::end(kReaders) && is_child_format(format);
  if (reader == std::end(kReaders) && !child) {
    const auto advice = std::ranges::find_if(kAdvice, named(ending));
    const bool has_advice = advice != std::end(kAdvice);
    const std::string name = has_advice ? ending : format.empty() ? "this format" : format;
    throw Error(concat(path, ": ", name, " is not read; ", has_advice ? advice->text : "",
                       "read are ", kReadFormats),
                ErrorKind::kAsset);
  }
  Asset asset = read_format(path, format, child ? nullptr : reader, options);
  check_asset(asset);
  return asset;
}

}  // namespace elastogen
