// SPDX-License-Identifier: Apache-2.0
#include "io/ply_splats.hpp"

#include "io/asset_check.hpp"
#include "io/packed_splats.hpp"
#include "io/splat_ply.hpp"

#include <algorithm>

namespace elastogen {
namespace {

const PlyElement* element_of(const PlyHeader& header, std::string_view name) {
  const auto found = std::ranges::find(header.elements, name, &PlyElement::name);
  return found == header.elements.end() ? nullptr : &*found;
}

/// Degree that the number of f_rest properties tells.
int degree_of(const PlyElement& vertex, const std::string& path) {
  const int64_t rest = std::ranges::count_if(
      vertex.properties, [](const PlyProperty& p) { return p.name.starts_with("f_rest_"); });
  for (int degree = 0; degree <= 3; ++degree)
    if (rest == 3 * (harmonic_count(degree) - 1)) return degree;
  throw Error(concat(path, ": its splats have ", rest,
                     " properties f_rest_*; harmonics of degree 0 to 3 have 0, 9, 24 or 45"),
              ErrorKind::kAsset);
}

SplatCloud read_plain(const PlyElement& vertex, PlyValues& values, const std::string& path) {
  std::vector<size_t> c;
  for (const char* name : {"x", "y", "z", "opacity", "scale_0", "scale_1", "scale_2", "rot_0",
                           "rot_1", "rot_2", "rot_3", "f_dc_0", "f_dc_1", "f_dc_2"})
    c.push_back(vertex.number(name, path));
  SplatCloud splats;
  splats.degree = degree_of(vertex, path);
  std::vector<size_t> rest;  // column of each further coefficient and channel
  for (int k = 1; k < harmonic_count(splats.degree); ++k)
    for (int channel = 0; channel < 3; ++channel)
      rest.push_back(
          vertex.number(concat("f_rest_", f_rest_index(splats.degree, k, channel)), path));

  std::vector<double> row;
  for (int64_t i = 0; i < vertex.count; ++i) {
    values.next_row(vertex, row);
    const auto at = [&](size_t k) { return float(row[c[k]]); };
    splats.position.push_back({row[c[0]], row[c[1]], row[c[2]]});
    splats.opacity.push_back(opacity_of_logit(at(3)));
    splats.scale.push_back({scale_of_log(at(4)), scale_of_log(at(5)), scale_of_log(at(6))});
    splats.rotation.push_back({at(7), at(8), at(9), at(10)});
    for (size_t channel = 0; channel < 3; ++channel) splats.harmonics.push_back(at(11 + channel));
    for (const size_t column : rest) splats.harmonics.push_back(float(row[column]));
  }
  return splats;
}

}  // namespace

bool is_splats(const PlyHeader& header) {
  const PlyElement* vertex = element_of(header, "vertex");
  if (!vertex) return false;
  const auto has = [&](std::string_view name) { return vertex->find({name}) >= 0; };
  return is_packed(*vertex) || (has("f_dc_0") && has("opacity") && has("scale_0") && has("rot_0"));
}

SplatCloud read_splats(const PlyHeader& header, PlyValues& values, Asset& asset) {
  const PlyElement& vertex = *element_of(header, "vertex");
  const bool packed = is_packed(vertex);
  if (const PlyElement* harmonics = element_of(header, "sh"); packed && harmonics)
    add_finding(asset, "harmonics", harmonics->count, "splats have packed harmonics");
  std::vector<SplatChunk> chunks;
  for (const PlyElement& element : header.elements) {
    if (&element == &vertex) break;
    if (packed && element.name == "chunk") {
      chunks = read_chunks(element, values, asset.path);
    } else {
      values.skip(element);
    }
  }
  return packed ? read_packed_splats(vertex, chunks, values, asset.path)
                : read_plain(vertex, values, asset.path);
}

}  // namespace elastogen
