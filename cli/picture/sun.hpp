// SPDX-License-Identifier: Apache-2.0
// Shadows of a light straight above, with soft edges.

#pragma once

#include "cli/picture/camera.hpp"
#include "cli/picture/canvas.hpp"

namespace elastogen {

/// A map of the greatest height above each place.
class Sun {
 public:
  /// @param above  camera that looks down on everything that casts a shadow; fitted to kEdge
  ///               samples.
  explicit Sun(const Camera& above);

  static constexpr int kEdge = 384;

  /// Copies the depths of a canvas into the map; several canvases may come at once.
  void take(const Canvas& canvas);

  /// Share of the light that is blocked above a place, 0 ... 1.
  float shadow(const Vec3& place) const;

 private:
  Camera above_;
  std::vector<float> height_;
};

}  // namespace elastogen
