// SPDX-License-Identifier: Apache-2.0
// The picture of one frame: subject, floor, colliders and shadows, seen by one camera all clip
// long.

#pragma once

#include "cli/picture/picture_options.hpp"
#include "cli/picture/stage.hpp"
#include "cli/picture/subject.hpp"

#include <functional>

namespace elastogen {

/// The frames of a clip, which are read again and in any order.
struct FrameSource {
  int64_t frames = 0, points = 0;
  double fps = 30;
  /// Positions of the carried points [m], (points, 3).
  std::function<void(int64_t frame, Out<double> positions)> positions;
  /// Deformation gradient there, (points, 9); asked only where the subject needs it.
  std::function<void(int64_t frame, Out<double> gradient)> gradient;
};

/// What is in the scene. All must outlive the picture.
struct PictureScene {
  Subject& subject;
  const std::vector<int32_t>& framed;  ///< points that pictures must show
  const std::vector<Collider>& colliders;
  UpAxis up;
};

class ScenePicture {
 public:
  /// Looks at all frames, so that each is seen whole.
  /// @throws Error (usage) without a frame or a point to show, or on a size that is not positive.
  ScenePicture(const PictureScene& scene, const FrameSource& source, const PictureOptions& options);

  /// Draws a frame; the same bits on any number of threads.
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
  Array<double> positions_, gradient_;  ///< of the frame that was read last
  Box places_;                          ///< of the framed points in all frames [m]
  Stage stage_;
  Box seen_;  ///< the same and what belongs to it, in the axes of the cameras [m]
};

}  // namespace elastogen
