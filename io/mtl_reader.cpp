// SPDX-License-Identifier: Apache-2.0
#include "io/mtl_reader.hpp"

#include "io/asset_check.hpp"
#include "io/byte_reader.hpp"
#include "io/safe_file.hpp"

#include <algorithm>
#include <unordered_map>

namespace elastogen {
namespace {

constexpr int64_t kMaxMtlBytes = 1 << 24;

/// File name in a map line: the rest behind the options and their values.
std::string_view map_name(std::string_view line) {
  static constexpr std::string_view kThreeNumbers[] = {"-o", "-s", "-t"};
  for (std::string_view rest = line;; line = rest) {
    const std::string_view option = next_word(rest);
    if (!option.starts_with('-')) return trimmed(line);
    int values = option == "-mm" ? 2 : 1;
    if (std::ranges::find(kThreeNumbers, option) != std::end(kThreeNumbers)) values = 3;
    for (int k = 0; k < values; ++k) {
      std::string_view after = rest;
      if (values == 3 && !to_double(next_word(after))) break;  // the last two may be left out
      next_word(rest);
    }
  }
}

void read_colour(std::string_view line, AssetMaterial& material) {
  std::array<float, 4> colour = material.base_colour;
  for (int k = 0; k < 3; ++k) {
    const std::optional<double> value = to_double(next_word(line));
    if (!value || !std::isfinite(*value)) return;
    colour[size_t(k)] = float(std::clamp(*value, 0., 1.));
  }
  material.base_colour = colour;
}

void read_opacity(std::string_view line, bool transparency, AssetMaterial& material) {
  const std::optional<double> value = to_double(trimmed(line));
  if (!value || !std::isfinite(*value)) return;
  const double opacity = std::clamp(*value, 0., 1.);
  material.base_colour[3] = float(transparency ? 1 - opacity : opacity);
}

void read_texture(Asset& asset, std::string_view line, AssetMaterial& material) {
  const std::string name(map_name(line));
  material.texture = resolve_beside(asset.path, name);
  if (material.texture.empty())
    add_finding(asset, "missing-texture", 1, "the texture " + name + " is not beside the asset");
}

}  // namespace

bool read_mtl(Asset& asset, const std::string& name) {
  // a file that is not there or cannot be read
  const std::string path = resolve_beside(asset.path, name);
  if (path.empty()) return false;
  std::string content;
  try {
    content = read_file(path, kMaxMtlBytes);
  } catch (const Error&) {
    return false;
  }
  if (is_utf16(content)) {
    add_finding(asset, "unread-material-file", 1, "material file is UTF-16 text: " + name);
    return true;
  }
  // materials by name
  std::unordered_map<std::string_view, AssetMaterial*> material_of;
  for (AssetMaterial& m : asset.materials) material_of[m.name] = &m;
  // lines change the material that newmtl named last, if the asset uses it
  AssetMaterial* material = nullptr;
  for (std::string_view text = without_mark(content); !text.empty();) {
    std::string_view line = next_line(text);
    const std::string_view keyword = next_word(line);
    if (keyword == "newmtl") {
      const auto found = material_of.find(trimmed(line));
      material = found == material_of.end() ? nullptr : found->second;
    } else if (material && keyword == "Kd") {
      read_colour(line, *material);
    } else if (material && (keyword == "d" || keyword == "Tr")) {
      read_opacity(line, keyword == "Tr", *material);
    } else if (material && keyword == "map_Kd") {
      read_texture(asset, line, *material);
    }
  }
  return true;
}

}  // namespace elastogen
