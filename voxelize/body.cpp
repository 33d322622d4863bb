// SPDX-License-Identifier: Apache-2.0
#include "voxelize/body.hpp"

namespace elastogen {

Body make_body(const Asset& asset, double size) {
  Body body;
  body.surface = pose_surface(asset, size);
  body.carried = body.surface.vertices;
  return body;
}

}  // namespace elastogen
