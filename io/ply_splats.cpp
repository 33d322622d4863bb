// SPDX-License-Identifier: Apache-2.0
#include "io/ply_splats.hpp"

#include "io/asset_check.hpp"
#include "io/packed_splats.hpp"
#include "io/splat_ply.hpp"

#include <algorithm>
#include <limits>

namespace elastogen {
namespace {

constexpr double kSplatTail = 0.02;  // share of the splats that may lie far away on each side

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

/// Where the numbers of a splat stand in its row.
struct SplatColumns {
  std::vector<size_t> position, scale, rotation, colour, rest;
  int opacity = -1;     ///< none: all are opaque
  bool is_rgb = false;  ///< colours in place of the first harmonic
  std::vector<size_t> own;
};

std::vector<size_t> numbers(const PlyElement& vertex, std::initializer_list<const char*> names,
                            const std::string& path) {
  std::vector<size_t> columns;
  for (const char* name : names) columns.push_back(vertex.number(name, path));
  return columns;
}

/// Columns that mean nothing for a splat and are carried; lists are named in `lists`.
std::vector<size_t> own_columns(const PlyElement& vertex, const SplatColumns& c,
                                std::vector<std::string>& lists) {
  std::vector<bool> known(vertex.properties.size());
  for (const auto* columns : {&c.position, &c.scale, &c.rotation, &c.colour, &c.rest})
    for (const size_t k : *columns) known[k] = true;
  if (c.opacity >= 0) known[size_t(c.opacity)] = true;
  for (const char* name : {"nx", "ny", "nz"})  // the layout has them, always 0
    if (const int k = vertex.find({name}); k >= 0) known[size_t(k)] = true;
  std::vector<size_t> own;
  for (size_t k = 0; k < known.size(); ++k) {
    if (known[k]) continue;
    if (vertex.properties[k].is_list) {
      lists.push_back(vertex.properties[k].name);
    } else {
      own.push_back(k);
    }
  }
  return own;
}

SplatColumns columns_of(const PlyElement& vertex, int degree, Asset& asset) {
  const std::string& path = asset.path;
  SplatColumns c;
  c.position = numbers(vertex, {"x", "y", "z"}, path);
  c.scale = numbers(vertex, {"scale_0", "scale_1", "scale_2"}, path);
  c.rotation = numbers(vertex, {"rot_0", "rot_1", "rot_2", "rot_3"}, path);
  c.opacity = vertex.find({"opacity"});
  if (c.opacity >= 0) vertex.number("opacity", path);  // no list
  c.is_rgb = vertex.find({"f_dc_0", "f_dc_1", "f_dc_2"}) < 0 && vertex.find({"red"}) >= 0;
  c.colour = c.is_rgb ? numbers(vertex, {"red", "green", "blue"}, path)
                      : numbers(vertex, {"f_dc_0", "f_dc_1", "f_dc_2"}, path);
  for (int k = 1; k < harmonic_count(degree); ++k)
    for (int channel = 0; channel < 3; ++channel)
      c.rest.push_back(vertex.number(concat("f_rest_", f_rest_index(degree, k, channel)), path));
  std::vector<std::string> lists;
  c.own = own_columns(vertex, c, lists);
  note_lost_columns(asset, lists);
  return c;
}

/// Median of the logarithms of the longest axes.
double middle_size(const SplatCloud& splats) {
  std::vector<double> size;
  for (const auto& s : splats.scale) {
    const float longest = *std::ranges::max_element(s);
    if (std::isfinite(longest) && longest > 0) size.push_back(std::log(double(longest)));
  }
  if (size.empty()) return 0;
  const auto middle = size.begin() + int64_t(size.size() / 2);
  std::nth_element(size.begin(), middle, size.end());
  return *middle;
}

/// Logarithm of the spacing of the splats, were they spread over a surface as wide as most of them.
double middle_spacing(const SplatCloud& splats) {
  double longest = 0;
  std::vector<double> x;
  for (size_t d = 0; d < 3; ++d) {
    x.clear();
    for (const Vec3& p : splats.position)
      if (std::isfinite(p[d])) x.push_back(p[d]);
    if (x.empty()) continue;
    std::ranges::sort(x);
    const size_t tail = size_t(kSplatTail * double(x.size()));
    longest = std::max(longest, x[x.size() - 1 - tail] - x[tail]);
  }
  return std::log(longest / std::sqrt(double(splats.position.size())));
}

/// Whether the numbers are standard deviations and opacities rather than their logarithms and
/// logits (the rule of the header).
bool seem_linear(const SplatCloud& raw, bool has_opacity) {
  float largest = 0;
  for (const auto& scale : raw.scale)
    for (const float s : scale) {
      if (s < 0) return false;
      if (std::isfinite(s)) largest = std::max(largest, s);
    }
  if (largest == 0) return false;
  if (has_opacity)
    for (const float a : raw.opacity)
      if (a < 0 || a > 1) return false;
  const double linear = middle_size(raw), logarithmic = std::exp(linear);
  const double spacing = middle_spacing(raw);
  return std::isfinite(spacing) && std::abs(linear - spacing) < std::abs(logarithmic - spacing);
}

/// Converts the file's sizes and opacities to standard deviations and opacities.
void convert(SplatCloud& splats, const SplatColumns& c, SplatScales scales, Asset& asset) {
  const int64_t count = int64_t(splats.position.size());
  const bool is_auto = scales == SplatScales::kAuto;
  const bool linear =
      is_auto ? seem_linear(splats, c.opacity >= 0) : scales == SplatScales::kLinear;
  if (is_auto && linear)
    add_finding(asset, "linear-splats", count,
                "splats have sizes and opacities that are no logarithms and logits");
  if (c.opacity < 0) add_finding(asset, "splat-opacity", count, "splats have no opacity");
  if (c.is_rgb)
    add_finding(asset, "splat-colours", count,
                "splats have red, green, blue in place of f_dc_0, f_dc_1, f_dc_2");
  if (linear) return;
  for (auto& scale : splats.scale)
    for (float& s : scale) s = scale_of_log(s);
  if (c.opacity >= 0)
    for (float& a : splats.opacity) a = opacity_of_logit(a);
}

float first_harmonic(const PlyProperty& property, bool is_rgb, double value) {
  const double range = colour_range(property.type);
  return is_rgb ? harmonic_of_colour(range > 0 ? value / range : value) : float(value);
}

SplatCloud read_plain(const PlyElement& vertex, PlyValues& values, SplatScales scales,
                      Asset& asset) {
  SplatCloud splats;
  // the meaning of each column
  splats.degree = degree_of(vertex, asset.path);
  const SplatColumns c = columns_of(vertex, splats.degree, asset);
  for (const size_t k : c.own)
    splats.own.columns.push_back({vertex.properties[k].name, vertex.properties[k].type});
  // rows as they are in the file
  std::vector<double> row;
  for (int64_t i = 0; i < vertex.count; ++i) {
    values.next_row(vertex, row);
    const auto at = [&](size_t k) { return float(row[k]); };
    const auto &p = c.position, &s = c.scale, &q = c.rotation;
    splats.position.push_back({row[p[0]], row[p[1]], row[p[2]]});
    splats.opacity.push_back(c.opacity < 0 ? 1 : at(size_t(c.opacity)));
    splats.scale.push_back({at(s[0]), at(s[1]), at(s[2])});
    splats.rotation.push_back({at(q[0]), at(q[1]), at(q[2]), at(q[3])});
    for (const size_t k : c.colour)
      splats.harmonics.push_back(first_harmonic(vertex.properties[k], c.is_rgb, row[k]));
    for (const size_t k : c.rest) splats.harmonics.push_back(at(k));
    for (size_t k = 0; k < c.own.size(); ++k) splats.own.add(k, row[c.own[k]]);
  }
  // scales and opacities in the numbers of SplatCloud
  convert(splats, c, scales, asset);
  note_own_columns(asset, splats.own);
  return splats;
}

}  // namespace

bool is_splats(const PlyHeader& header) {
  const PlyElement* vertex = element_of(header, "vertex");
  return vertex && (is_packed(*vertex) ||
                    vertex->find({"scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2",
                                  "rot_3", "f_dc_0", "f_dc_1", "f_dc_2"}) >= 0);
}

SplatCloud read_splats(const PlyHeader& header, PlyValues& values, SplatScales scales,
                       Asset& asset) {
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
                : read_plain(vertex, values, scales, asset);
}

}  // namespace elastogen
