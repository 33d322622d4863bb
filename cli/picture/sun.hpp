// SPDX-License-Identifier: Apache-2.0
// What shadow a light straight above throws, with soft edges.

#pragma once

#include "cli/picture/camera.hpp"
#include "cli/picture/canvas.hpp"

namespace elastogen {

/// A map of the highest thing above each place.
class Sun {
 public:
  /// @param above  looks down on all that throws a shadow; fitted to a map of kEdge samples.
  explicit Sun(const Camera& above);

  static constexpr int kEdge = 384;

  /// Takes what a canvas of the map shows; several canvases may come at once.
  void take(const Canvas& canvas);

  /// Share of the light that something above takes from a place, 0 ... 1.
  float shadow(const Vec3& place) const;

 private:
  Camera above_;
  std::vector<float> height_;
};

}  // namespace elastogen
