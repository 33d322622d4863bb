// SPDX-License-Identifier: Apache-2.0
// Colours and attributes with which vertices and points of an asset are painted.

#pragma once

#include "io/asset.hpp"
#include "io/triangle_corners.hpp"
#include "voxelize/regions.hpp"

#include <map>
#include <set>

namespace elastogen {

/// Where an asset is painted as a selection asks for. A colour is the one that is shown there,
/// interpolated in linear RGB, of which each 8-bit sRGB channel is within kColourTolerance of that
/// of the selection. An attribute is interpolated too; of several that match one is enough.
class Paint {
 public:
  /// The asset must outlive it. @throws Error (usage) if it has no colours or no such attribute.
  Paint(const Asset& asset, const Selection& selection);

  /// @param weights  of the corners of a triangle, which sum to 1.
  bool at(const TriangleCorners& corners, const Vec3& weights) const;

  /// At a drawn vertex of a mesh.
  bool at_vertex(const Mesh& mesh, int32_t drawn) const;

  /// At a point or splat.
  bool at_point(size_t point) const;

 private:
  using Column = const std::vector<double>*;

  void find_attribute();
  void take(const Mesh* mesh, const std::vector<OwnColumn>& columns, std::set<std::string>& names);
  bool is_colour(const std::array<double, 3>& linear) const;
  bool is_value(double value) const;

  const Asset& asset_;
  Selection selection_;
  std::map<const Mesh*, std::vector<Column>> columns_;  ///< of each mesh, by position
  std::vector<size_t> of_points_;                       ///< columns of points
};

inline constexpr int kColourTolerance = 16;

/// Colour of a splat that is independent of the view, linear RGBA.
std::array<float, 4> splat_colour(const SplatCloud& splats, size_t splat);

}  // namespace elastogen
