// SPDX-License-Identifier: Apache-2.0
// What a picture is of: the mesh, points or splats of an asset, moved frame by frame.

#pragma once

#include "cli/picture/camera.hpp"
#include "cli/picture/canvas.hpp"
#include "core/array.hpp"
#include "voxelize/body.hpp"

#include <memory>
#include <string>
#include <vector>

namespace elastogen {

/// Drawn in three steps: pose, see, and draw, which may be called for several canvases at once.
class Subject {
 public:
  virtual ~Subject() = default;

  /// Whether pose needs the deformation gradient.
  virtual bool needs_gradient() const { return false; }

  /// Takes a frame.
  /// @param positions  of the carried points [m], (points, 3); they must outlive see.
  /// @param gradient   F there, (points, 9), where it is needed.
  virtual void pose(In<double> positions, In<double> gradient) = 0;

  /// Projects the frame.
  virtual void see(const Camera& camera) = 0;

  /// Draws what lies nearer than the depths of the canvas.
  virtual void draw(Canvas& canvas) const = 0;

  /// Draws the depths of what throws a shadow.
  virtual void cast(Canvas& canvas) const { draw(canvas); }
};

/// How a surface that faces somewhere is lit from above the viewer's left shoulder.
/// @param normal  unit: right, up and back of the camera; towards the viewer.
/// @return a factor for the light, at most 1.
float light_on(const Vec3& normal);

/// Triangles with their materials, textures and colours of vertices. Both sides are lit, smoothly
/// where smooth_corners (cli/picture/smooth_corners.hpp) says so.
/// @param max_edge  longest edge of a texture that makes sense [texels].
/// @param notes     gets a sentence for every texture that cannot be shown.
/// @throws Error as base_colour_looks.
std::unique_ptr<Subject> make_mesh_subject(const Asset& asset, const Surface& surface, int max_edge,
                                           std::vector<std::string>& notes);

/// Discs as large as the spacing of the points, in their colours, else grey, darker further away;
/// lit where there are normals.
std::unique_ptr<Subject> make_point_subject(const PointCloud& points, const Array<double>& rest);

/// Splats: F S F^T projected (elliptical weighted averages: Zwicker et al. 2001), blended back to
/// front, colours by harmonics in the direction of view.
/// @param scale  metres per file unit.
std::unique_ptr<Subject> make_splat_subject(const SplatCloud& splats, double scale);

}  // namespace elastogen
