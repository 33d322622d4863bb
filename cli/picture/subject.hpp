// SPDX-License-Identifier: Apache-2.0
// The subject of a picture: mesh, points or splats of an asset, moved frame by frame.

#pragma once

#include "cli/picture/camera.hpp"
#include "cli/picture/canvas.hpp"
#include "core/array.hpp"
#include "voxelize/body.hpp"

#include <memory>
#include <string>
#include <vector>

namespace elastogen {

/// Drawn in three steps: pose, see and draw. draw may run for several canvases at once.
class Subject {
 public:
  virtual ~Subject() = default;

  /// Whether pose needs the deformation gradient.
  virtual bool needs_gradient() const { return false; }

  /// Moves the subject to a frame.
  /// @param positions  of the carried points [m], (points, 3); they must outlive the call of see.
  /// @param gradient   F at these points, (points, 9), if needed.
  virtual void pose(In<double> positions, In<double> gradient) = 0;

  /// Projects the frame to the camera.
  virtual void see(const Camera& camera) = 0;

  /// Draws samples that lie nearer than the depths of the canvas.
  virtual void draw(Canvas& canvas) const = 0;

  /// Draws the depths of everything that casts a shadow.
  virtual void cast(Canvas& canvas) const { draw(canvas); }
};

/// Light on a surface of some direction, from above the viewer's left shoulder.
/// @param normal  unit vector in right, up and back of the camera; it points towards the viewer.
/// @return a factor for the light, at most 1.
float light_on(const Vec3& normal);

/// Triangles with their materials, textures and colours of vertices. Both sides are lit; corners
/// that smooth_corners (cli/picture/smooth_corners.hpp) joins share a normal.
/// @param max_edge  longest edge to which textures are reduced [texels].
/// @param notes     gets a sentence for every texture that cannot be shown.
/// @throws Error as base_colours.
std::unique_ptr<Subject> make_mesh_subject(const Asset& asset, const Surface& surface, int max_edge,
                                           std::vector<std::string>& notes);

/// Discs as large as the spacing of the points, in their colours; without colours grey, darker with
/// distance; lit if there are normals.
std::unique_ptr<Subject> make_point_subject(const PointCloud& points, const Array<double>& rest);

/// Splats: F S F^T projected (elliptical weighted averages: Zwicker et al. 2001), blended, with
/// colours by harmonics in the direction of view.
/// @param scale  metres per file unit.
std::unique_ptr<Subject> make_splat_subject(const SplatCloud& splats, double scale);

}  // namespace elastogen
