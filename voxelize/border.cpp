// SPDX-License-Identifier: Apache-2.0
#include "voxelize/border.hpp"

#include "core/vec3.hpp"
#include "voxelize/regions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace elastogen {
namespace {

constexpr double kNoFace = std::numeric_limits<double>::infinity();
constexpr double kSameEdge = 1e-12;  // shares of a distance below which two of them are equal

/// Distances of a point beyond the nearer face along each axis, negative between the faces.
Vec3 beyond_faces(const Border& box, const Vec3& point) {
  Vec3 beyond;
  for (size_t d = 0; d < 3; ++d)
    beyond[d] = std::max(box.lower[d] - point[d], point[d] - box.upper[d]);
  return beyond;
}

/// Gradient of the distance of a box: outside away from the nearest point, inside towards the
/// nearest face, or between faces that are equally near.
Vec3 box_gradient(const Border& box, const Vec3& point) {
  const Vec3 beyond = beyond_faces(box, point);
  const double most = std::max({beyond[0], beyond[1], beyond[2]});
  Vec3 n = {};
  for (size_t d = 0; d < 3; ++d) {
    const double sign = point[d] - box.upper[d] >= box.lower[d] - point[d] ? 1 : -1;
    if (most > 0)
      n[d] = sign * std::max(beyond[d], 0.0);
    else if (beyond[d] >= most - kSameEdge * (1 + std::abs(most)))
      n[d] = sign;
  }
  return scaled(n, 1 / norm(n));
}

bool is_whole(double x) {
  return std::abs(x - std::round(x)) <= kSamePlane;
}

}  // namespace

std::optional<Border> border_of(const Selection& selection, const PlacedBox& box) {
  // half spaces have one face that is not at infinity; of balls both corners are the centre
  Border border;
  switch (selection.kind) {
    case Selection::Kind::kHalfSpace: {
      border.is_plane = true;
      border.lower = {-kNoFace, -kNoFace, -kNoFace};
      border.upper = {kNoFace, kNoFace, kNoFace};
      const auto axis = size_t(selection.axis);
      const double place = coordinate(selection.lower[axis], selection.axis, box);
      (selection.below ? border.upper : border.lower)[axis] = place;
      return border;
    }
    case Selection::Kind::kBox:
    case Selection::Kind::kSphere:
      border.radius = selection.kind == Selection::Kind::kSphere ? selection.radius : 0;
      for (size_t d = 0; d < 3; ++d) {
        border.lower[d] = coordinate(selection.lower[d], int(d), box);
        border.upper[d] =
            border.radius > 0 ? border.lower[d] : coordinate(selection.upper[d], int(d), box);
      }
      return border;
    default:
      return std::nullopt;
  }
}

double distance(const Border& border, const Vec3& point) {
  if (border.radius > 0) return safe_norm(minus(point, border.lower)) - border.radius;
  const Vec3 beyond = beyond_faces(border, point);
  const double most = std::max({beyond[0], beyond[1], beyond[2]});
  if (most <= 0) return most;
  return safe_norm({std::max(beyond[0], 0.0), std::max(beyond[1], 0.0), std::max(beyond[2], 0.0)});
}

Vec3 distance_gradient(const Border& border, const Vec3& point) {
  if (border.radius == 0) return box_gradient(border, point);
  const Vec3 from = minus(point, border.lower);
  const double length = safe_norm(from);
  return length > 0 ? scaled(from, 1 / length) : Vec3{1, 0, 0};
}

bool reaches(const Border& border, const Box& body) {
  for (size_t d = 0; d < 3; ++d) {
    const double margin = 1e-9 * std::max({body.extent(0), body.extent(1), body.extent(2)});
    if (border.lower[d] - border.radius > body.upper[d] + margin ||
        border.upper[d] + border.radius < body.lower[d] - margin)
      return false;
  }
  return true;
}

bool fits(const Border& border, const Box& body, double h, const Vec3& origin) {
  // all of the body lies behind it
  double farthest = -kNoFace;
  for (int c = 0; c < 8; ++c) {
    Vec3 corner;
    for (size_t d = 0; d < 3; ++d) corner[d] = c >> d & 1 ? body.upper[d] : body.lower[d];
    farthest = std::max(farthest, distance(border, corner));
  }
  if (farthest <= 0) return true;
  if (border.radius > 0 || !reaches(border, body)) return false;
  // all faces within the body lie in layers of nodes
  for (size_t d = 0; d < 3; ++d)
    for (const double face : {border.lower[d], border.upper[d]})
      if (face > body.lower[d] - kSamePlane * h && face < body.upper[d] + kSamePlane * h &&
          !is_whole((face - origin[d]) / h))
        return false;
  return true;
}

}  // namespace elastogen
