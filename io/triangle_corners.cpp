// SPDX-License-Identifier: Apache-2.0
#include "io/triangle_corners.hpp"

#include <utility>

namespace elastogen {

std::vector<TriangleCorners> triangle_corners(const Asset& asset, const Surface& surface) {
  std::vector<TriangleCorners> corners;
  for (const SurfaceInstance& instance : surface.instances) {
    const Mesh& mesh = asset.meshes[size_t(instance.mesh)];
    for (const TriangleGroup& group : mesh.groups)
      for (size_t k = 0; k + 2 < group.corner.size(); k += 3) {
        std::array<int32_t, 3> drawn = {group.corner[k], group.corner[k + 1], group.corner[k + 2]};
        const int64_t second = instance.first_vertex + mesh.position_of[size_t(drawn[1])];
        if (surface.triangles(int64_t(corners.size()), 1) != second) std::swap(drawn[1], drawn[2]);
        corners.push_back({&mesh, drawn});
      }
  }
  return corners;
}

}  // namespace elastogen
