// SPDX-License-Identifier: Apache-2.0
#include "io/stl_reader.hpp"

#include "io/asset_check.hpp"
#include "io/byte_reader.hpp"
#include "io/safe_file.hpp"

#include <filesystem>
#include <unordered_map>

namespace elastogen {
namespace {

constexpr int64_t kStlHeaderBytes = 80, kFacetBytes = 50;
constexpr int64_t kMaxFacets = std::numeric_limits<int32_t>::max() / 3;

/// Facets that the count of a binary file claims, -1 if there is no count.
int64_t claimed_facets(std::string_view bytes) {
  if (int64_t(bytes.size()) < kStlHeaderBytes + 4) return -1;
  return ByteReader(bytes.substr(kStlHeaderBytes), "").read<uint32_t>();
}

std::vector<Vec3> read_binary(std::string_view bytes, int64_t facets, const std::string& path) {
  ELASTOGEN_CHECK_ASSET(facets <= kMaxFacets, path, ": ", facets, " facets are too many");
  ByteReader reader(bytes, path);
  reader.skip(kStlHeaderBytes + 4, "bytes of a binary STL header");
  reader.claim(facets, kFacetBytes, "facets of a binary STL");
  std::vector<Vec3> position;
  position.reserve(size_t(3 * facets));
  for (int64_t f = 0; f < facets; ++f) {
    reader.skip(12, "bytes of a normal");
    for (int k = 0; k < 3; ++k) {
      const float x = reader.read<float>(), y = reader.read<float>(), z = reader.read<float>();
      position.push_back({x, y, z});
    }
    reader.skip(2, "bytes of an attribute");
  }
  return position;
}

std::string lower(std::string_view word) {
  std::string out(word);
  for (char& c : out) c = c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c;
  return out;
}

/// Solids of a text by name, in the order in which they come.
class StlText {
 public:
  StlText(std::string_view text, Asset& asset) : text_(text), asset_(asset) {}

  void read() {
    while (!text_.empty()) {
      std::string_view line = next_line(text_);
      ++line_;
      read_line(line);
    }
    ELASTOGEN_CHECK_ASSET(in_facet_ == 0, asset_.path, ": the file ends within a facet");
    ELASTOGEN_CHECK_ASSET(positions_ <= 3 * kMaxFacets, asset_.path, ": too many facets");
    if (asset_.meshes.empty()) mesh();
    // a single solid has the order of the file already
    if (asset_.meshes.size() == 1) asset_.meshes[0].file_position.clear();
  }

 private:
  template <class... Parts>
  void check(bool condition, const Parts&... parts) const {
    ELASTOGEN_CHECK_ASSET(condition, asset_.path, ':', line_, ": ", parts...);
  }

  /// Names of solids may have any characters; normals are not used.
  void read_line(std::string_view line) {
    const std::string keyword = lower(next_word(line).substr(0, 10));
    if (keyword == "vertex") {
      read_vertex(line);
    } else if (keyword == "facet" || keyword == "endfacet") {
      end_facet();
    } else if (keyword == "solid") {
      end_facet();
      name_ = trimmed(line);
      mesh_ = -1;
    } else {
      check(keyword.empty() || keyword == "endsolid" || keyword == "outer" ||
                keyword == "endloop" || keyword == "color",
            "unknown keyword \"", keyword, '"');
    }
  }

  void read_vertex(std::string_view line) {
    Vec3 p;
    for (double& x : p) {
      const std::string_view word = next_word(line);
      const std::optional<double> value = to_double(word);
      check(value.has_value(), "a number is expected, not \"", word.substr(0, 40), '"');
      x = *value;
    }
    Mesh& to = mesh();
    to.file_position.push_back(int32_t(std::min(positions_++, 3 * kMaxFacets)));
    to.position.push_back(p);
    ++in_facet_;
  }

  void end_facet() {
    check(in_facet_ == 0 || in_facet_ == 3, "a facet of ", in_facet_, " vertices, not of three");
    in_facet_ = 0;
  }

  /// The mesh of the current solid. Solids with one name share it; the file's name replaces a
  /// missing one.
  Mesh& mesh() {
    if (mesh_ >= 0) return asset_.meshes[size_t(mesh_)];
    const std::string name =
        name_.empty() ? std::filesystem::path(asset_.path).stem().string() : name_;
    const auto [entry, is_new] = mesh_of_.try_emplace(name, int(asset_.meshes.size()));
    mesh_ = entry->second;
    if (is_new) {
      asset_.nodes.push_back({name, -1, kIdentity4, mesh_});
      asset_.meshes.emplace_back().name = name;
    }
    return asset_.meshes[size_t(mesh_)];
  }

  std::string_view text_;
  Asset& asset_;
  std::string name_;
  int mesh_ = -1;
  int64_t line_ = 0, positions_ = 0, in_facet_ = 0;
  std::unordered_map<std::string, int> mesh_of_;
};

void read_solid(std::string_view bytes, int64_t facets, Asset& asset) {
  Mesh& mesh = asset.meshes.emplace_back();
  mesh.position = read_binary(bytes, facets, asset.path);
  mesh.name = std::filesystem::path(asset.path).stem().string();
  asset.nodes.push_back({mesh.name, -1, kIdentity4, 0});
}

}  // namespace

Asset parse_stl(std::string_view bytes, const std::string& path) {
  const int64_t facets = claimed_facets(bytes);
  const std::string_view text = without_mark(bytes);
  const bool size_fits =
      facets >= 0 && int64_t(bytes.size()) == kStlHeaderBytes + 4 + facets * kFacetBytes;
  const bool is_text =
      lower(trimmed(text.substr(0, 16)).substr(0, 5)) == "solid" && bytes.find('\0') == bytes.npos;
  Asset asset;
  asset.path = path;
  asset.format = "stl";
  if (is_text && !size_fits)
    StlText(text, asset).read();
  else
    read_solid(bytes, facets, asset);
  for (Mesh& mesh : asset.meshes) {
    TriangleGroup& group = mesh.groups.emplace_back();
    for (int32_t i = 0; i < int32_t(mesh.position.size()); ++i) {
      mesh.position_of.push_back(i);
      group.corner.push_back(i);
    }
  }
  return asset;
}

Asset read_stl(const std::string& path) {
  return parse_stl(read_file(path), path);
}

}  // namespace elastogen
