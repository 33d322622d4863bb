// SPDX-License-Identifier: Apache-2.0
// The picture of one frame: subject, floor, colliders and shadows, seen by one camera.

#pragma once

#include "cli/picture/picture_options.hpp"
#include "cli/picture/stage.hpp"
#include "cli/picture/subject.hpp"

#include <functional>

namespace elastogen {

/// The frames of a clip, which may be read repeatedly and in any order.
struct FrameSource {
  int64_t frames = 0, points = 0;
  double fps = 30;
  /// Positions of the carried points [m], (points, 3).
  std::function<void(int64_t frame, Out<double> positions)> positions;
  /// Deformation gradient at the carried points, (points, 9); called only if the subject needs it.
  std::function<void(int64_t frame, Out<double> gradient)> gradient;
};

/// Contents of the scene. All of them must outlive the picture.
struct PictureScene {
  Subject& subject;
  const std::vector<int32_t>& framed;  ///< points that pictures must show
  const std::vector<Collider>& colliders;
  UpAxis up;
};

class ScenePicture {
 public:
  /// Reads all frames once, so that the view contains each of them.
  /// @throws Error (usage) without a frame or a point to show, or on a size that is not positive.
  ScenePicture(const PictureScene& scene, const FrameSource& source, const PictureOptions& options);

  /// Draws a frame; any number of threads gives the same bits.
  Pixels draw(int64_t frame);

  /// The camera of a frame, in samples.
  Camera camera(int64_t frame) const;

 private:
  Vec3 place(int32_t point) const;
  Camera directions(int64_t frame) const;
  Box all_places();
  Box all_seen();
  std::optional<Sun> shine();

  PictureScene scene_;
  const FrameSource& source_;
  PictureOptions options_;
  Array<double> positions_, gradient_;  ///< of the frame read last
  Box places_;                          ///< box of the framed points in all frames [m]
  Stage stage_;
  Box seen_;  ///< box of points, feet and solids, in the axes of the cameras [m]
};

}  // namespace elastogen
