// SPDX-License-Identifier: Apache-2.0
#include "io/stl_reader.hpp"

#include "io/asset_check.hpp"
#include "io/byte_reader.hpp"
#include "io/safe_file.hpp"

#include <filesystem>

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

/// Lines of keywords; names of solids may hold anything, normals are not used.
std::vector<Vec3> read_text(std::string_view text, const std::string& path) {
  std::vector<Vec3> position;
  size_t facet_begin = 0;
  for (int64_t number = 1; !text.empty(); ++number) {
    std::string_view line = next_line(text);
    const std::string keyword = lower(next_word(line).substr(0, 10));
    if (keyword == "vertex") {
      Vec3 p;
      for (double& x : p) {
        const std::string_view word = next_word(line);
        const std::optional<double> value = to_double(word);
        ELASTOGEN_CHECK_ASSET(value.has_value(), path, ':', number,
                              ": a number is expected, not \"", word.substr(0, 40), '"');
        x = *value;
      }
      position.push_back(p);
    } else if (keyword == "facet" || keyword == "endfacet") {
      const size_t n = position.size() - facet_begin;
      ELASTOGEN_CHECK_ASSET(n == 0 || n == 3, path, ':', number, ": a facet of ", n,
                            " vertices, not of three");
      facet_begin = position.size();
    } else {
      ELASTOGEN_CHECK_ASSET(keyword.empty() || keyword == "solid" || keyword == "endsolid" ||
                                keyword == "outer" || keyword == "endloop" || keyword == "color",
                            path, ':', number, ": unknown keyword \"", keyword, '"');
    }
  }
  ELASTOGEN_CHECK_ASSET(position.size() == facet_begin, path, ": the file ends within a facet");
  ELASTOGEN_CHECK_ASSET(int64_t(position.size()) <= 3 * kMaxFacets, path, ": too many facets");
  return position;
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
  Mesh& mesh = asset.meshes.emplace_back();
  mesh.position = is_text && !size_fits ? read_text(text, path) : read_binary(bytes, facets, path);
  mesh.name = std::filesystem::path(path).stem().string();
  TriangleGroup& group = mesh.groups.emplace_back();
  for (int32_t i = 0; i < int32_t(mesh.position.size()); ++i) {
    mesh.position_of.push_back(i);
    group.corner.push_back(i);
  }
  asset.nodes.push_back({mesh.name, -1, kIdentity4, 0});
  return asset;
}

Asset read_stl(const std::string& path) {
  return parse_stl(read_file(path), path);
}

}  // namespace elastogen
