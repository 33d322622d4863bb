// SPDX-License-Identifier: Apache-2.0
#include "scene/paint.hpp"

#include "core/error.hpp"
#include "io/byte_reader.hpp"
#include "io/splat_ply.hpp"
#include "scene/name_pattern.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

bool has_colours(const Asset& asset) {
  if (asset.points) return !asset.points->colour.empty();
  return asset.splats ||
         std::ranges::any_of(asset.meshes, [](const Mesh& mesh) { return !mesh.colour.empty(); });
}

/// The file's own columns of a cloud; none of a mesh.
const OwnColumns* columns_of(const Asset& asset) {
  return asset.points ? &asset.points->own : asset.splats ? &asset.splats->own : nullptr;
}

}  // namespace

Paint::Paint(const Asset& asset, const Selection& selection)
    : asset_(asset), selection_(selection) {
  if (selection.kind == Selection::Kind::kAttribute)
    find_attribute();
  else
    ELASTOGEN_CHECK(has_colours(asset), "the asset has no colours of vertices");
}

void Paint::take(const Mesh* mesh, const std::vector<OwnColumn>& columns,
                 std::set<std::string>& names) {
  for (const OwnColumn& column : columns) {
    names.insert(column.name);
    if (matches_attribute(selection_.name, column.name)) columns_[mesh].push_back(&column.value);
  }
}

void Paint::find_attribute() {
  std::set<std::string> names;
  for (const Mesh& mesh : asset_.meshes) {
    take(&mesh, mesh.own, names);
    take(&mesh, mesh.attributes, names);
  }
  if (const OwnColumns* own = columns_of(asset_))
    for (size_t k = 0; k < own->columns.size(); ++k) {
      names.insert(own->columns[k].name);
      if (matches_attribute(selection_.name, own->columns[k].name)) of_points_.push_back(k);
    }
  ELASTOGEN_CHECK(!columns_.empty() || !of_points_.empty(), "the asset has no attribute '",
                  selection_.name, "'; it has ", names.empty() ? "none" : quoted_names(names));
}

bool Paint::is_colour(const std::array<double, 3>& linear) const {
  for (size_t c = 0; c < 3; ++c) {
    const double srgb = srgb_from_linear(std::clamp(linear[c], 0.0, 1.0));
    if (!(std::abs(std::round(255 * srgb) - selection_.colour[c]) <= kColourTolerance))
      return false;
  }
  return true;
}

bool Paint::is_value(double value) const {
  if (value == selection_.bound) return selection_.with_bound;
  return selection_.below ? value < selection_.bound : value > selection_.bound;
}

bool Paint::at(const TriangleCorners& corners, const Vec3& weights) const {
  const Mesh& mesh = *corners.mesh;
  if (selection_.kind == Selection::Kind::kColour) {
    if (mesh.colour.empty()) return false;
    std::array<double, 3> mean = {};
    for (size_t c = 0; c < 3; ++c)
      for (size_t k = 0; k < 3; ++k)
        mean[k] += weights[c] * mesh.colour[size_t(corners.drawn[c])][k];
    return is_colour(mean);
  }
  const auto columns = columns_.find(&mesh);
  if (columns == columns_.end()) return false;
  return std::ranges::any_of(columns->second, [&](Column column) {
    // between the values of the corners also after rounding, so that equal ones stay what they are
    double mean = 0, least = INFINITY, most = -INFINITY;
    for (size_t c = 0; c < 3; ++c) {
      if (weights[c] == 0) continue;
      const double value = (*column)[size_t(mesh.position_of[size_t(corners.drawn[c])])];
      mean += weights[c] * value;
      least = std::min(least, value);
      most = std::max(most, value);
    }
    return is_value(std::min(std::max(mean, least), most));
  });
}

bool Paint::at_vertex(const Mesh& mesh, int32_t drawn) const {
  return at({&mesh, {drawn, drawn, drawn}}, {1, 0, 0});
}

bool Paint::at_point(size_t point) const {
  if (selection_.kind == Selection::Kind::kColour) {
    const std::array<float, 4> colour =
        asset_.points ? asset_.points->colour[point] : splat_colour(*asset_.splats, point);
    return is_colour({colour[0], colour[1], colour[2]});
  }
  return std::ranges::any_of(
      of_points_, [&](size_t k) { return is_value(columns_of(asset_)->value(point, k)); });
}

std::array<float, 4> splat_colour(const SplatCloud& splats, size_t splat) {
  const size_t width = 3 * size_t(harmonic_count(splats.degree));
  std::array<float, 4> colour = {0, 0, 0, 1};
  for (size_t c = 0; c < 3; ++c)
    colour[c] = linear_from_srgb(
        std::clamp(0.5 + kHarmonic0 * splats.harmonics[width * splat + c], 0.0, 1.0));
  return colour;
}

}  // namespace elastogen
