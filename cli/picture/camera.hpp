// SPDX-License-Identifier: Apache-2.0
// The view of a picture: an orthographic camera with one scale for a whole clip.

#pragma once

#include "cli/picture/picture_options.hpp"
#include "core/vec3.hpp"
#include "io/asset_pose.hpp"

namespace elastogen {

/// Orthographic view: right, up and back (towards the viewer) are unit vectors in the axes of the
/// asset.
struct Camera {
  /// Components of a point relative to the pivot along right, up and back [m].
  Vec3 turn(const Vec3& p) const;
  /// Place on the grid of samples (y runs down), and distance towards the viewer from the plane
  /// through the pivot [m].
  Vec3 project(const Vec3& p) const;

  Vec3 right = {1, 0, 0}, up = {0, 1, 0}, back = {0, 0, 1};
  Vec3 pivot = {};                    ///< [m]
  std::array<double, 2> centre = {};  ///< right and up of the picture's middle, from the pivot [m]
  std::array<double, 2> middle = {};  ///< middle of the picture [samples]
  double scale = 1;                   ///< samples per metre
};

/// A camera for a view, without its scale.
/// @param turned  share of a full turn of the turntable, 0 ... 1.
Camera camera_of(View view, const UpAxis& up, const Vec3& pivot, double turned = 0);

/// A camera that looks down along up, for shadows of a light from there.
Camera camera_above(const UpAxis& up, const Vec3& pivot);

/// Unit vector that points up.
Vec3 up_vector(const UpAxis& up);

/// Sets centre, middle and scale so that a picture of these samples shows a box with a margin.
/// @param box     box in right, up and back, as turn gives them.
/// @param about   whether the pivot stays in the middle from left to right.
void fit(Camera& camera, const Box& box, int width, int height, bool about);

}  // namespace elastogen
