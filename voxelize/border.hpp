// SPDX-License-Identifier: Apache-2.0
// Borders of what holds a body, in metres: signed distances, and which of them the grid fits.

#pragma once

#include "core/base.hpp"

#include <compare>
#include <cstdint>
#include <optional>
#include <vector>

namespace elastogen {

struct PlacedBox;
struct Selection;

/// A box, closed, whose faces may lie at infinity (a half space has one that does not), or a ball.
struct Border {
  Vec3 lower = {}, upper = {};  ///< corners; of a ball both are its centre [m]
  double radius = 0;            ///< of a ball [m], 0: a box
  bool is_plane = false;        ///< a half space

  bool operator==(const Border&) const = default;
  auto operator<=>(const Border&) const = default;
};

/// A voxel in which a border holds a part of the body and leaves another part free.
struct BorderVoxel {
  int32_t voxel, border;
};

/// Border of a selection, none of `all` and of parts of the asset. @param box  of the asset [m].
std::optional<Border> border_of(const Selection& selection, const PlacedBox& box);

/// Signed distance of a point, positive outside, and its gradient, of length 1.
double distance(const Border& border, const Vec3& point);
Vec3 distance_gradient(const Border& border, const Vec3& point);

/// Nodes nearer than this share of the edge, or behind the border, are dependent.
inline double nearest_free(const Border& border) {
  return border.is_plane ? 0.1 : 0.5;
}

/// Whether pinning nodes holds the body at the border: all faces of it within the body lie in layers
/// of nodes, or all of the body lies behind it.
/// @param body  box of the body [m].
bool fits(const Border& border, const Box& body, double h, const Vec3& origin);

/// Whether the border's box meets that of the body, but for what is not seen at a voxel's scale.
bool reaches(const Border& border, const Box& body);

/// Distances [voxel edges] below which a plane and a layer of nodes are one.
inline constexpr double kSamePlane = 1e-6;

}  // namespace elastogen
