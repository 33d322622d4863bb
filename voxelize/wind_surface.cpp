// SPDX-License-Identifier: Apache-2.0
#include "core/vec3.hpp"
#include "voxelize/embedding.hpp"
#include "voxelize/voxelize.hpp"

#include <algorithm>

namespace elastogen {
namespace {

/// Centres and area vectors of the triangles of a surface, large ones in parts.
class Facets {
 public:
  Facets(double longest, const std::function<bool(const Vec3&)>& is_held)
      : longest_(longest), is_held_(is_held) {}

  void add(const Vec3& a, const Vec3& b, const Vec3& c, int32_t part) {
    const double ab = norm(minus(a, b)), bc = norm(minus(b, c)), ca = norm(minus(c, a));
    const double most = std::max({ab, bc, ca});
    if (most > longest_) {  // halved at the longest edge
      if (ab < most) return bc == most ? add(b, c, a, part) : add(c, a, b, part);
      const Vec3 middle = scaled(plus(a, b), 0.5);
      add(a, middle, c, part);
      add(middle, b, c, part);
      return;
    }
    const Vec3 area = scaled(cross(minus(b, a), minus(c, a)), 0.5);
    const Vec3 centre = scaled(plus(plus(a, b), c), 1.0 / 3);
    if (!(dot(area, area) > 0) || is_held_(centre)) return;
    centres.push_back(centre);
    areas.push_back(area);
    parts.push_back(part);
  }

  std::vector<Vec3> centres, areas;
  std::vector<int32_t> parts;

 private:
  double longest_;
  const std::function<bool(const Vec3&)>& is_held_;
};

}  // namespace

void add_wind_surface(const VoxelGrid& grid, const Surface& surface,
                      const std::function<bool(const Vec3&)>& is_held, Wind& wind) {
  Facets facets(grid.h, is_held);
  for (int64_t t = 0; t < surface.triangles.rows(); ++t) {
    Vec3 corner[3];
    for (int c = 0; c < 3; ++c)
      std::copy_n(surface.vertices.row(surface.triangles(t, c)), 3, corner[c].begin());
    const int32_t part = surface.part.empty() ? 0 : surface.part(t);
    if (part >= 0) facets.add(corner[0], corner[1], corner[2], part);
  }
  const auto count = int64_t(facets.centres.size());
  Array<double> centres(count, 3);
  Array<int32_t> parts(count);
  wind.area = Array<double>(count, 3);
  for (int64_t p = 0; p < count; ++p) {
    std::ranges::copy(facets.centres[size_t(p)], centres.row(p));
    std::ranges::copy(facets.areas[size_t(p)], wind.area.row(p));
    parts(p) = facets.parts[size_t(p)];
  }
  Embedding embedding = embed(grid, centres, parts);
  wind.voxel = std::move(embedding.voxel);
  wind.weights = std::move(embedding.weights);
}

}  // namespace elastogen
