// SPDX-License-Identifier: Apache-2.0
#include "core/error.hpp"
#include "core/vec3.hpp"
#include "voxelize/embedding.hpp"
#include "voxelize/voxelize.hpp"

#include <algorithm>
#include <unordered_map>

namespace elastogen {
namespace {

/// Points with their share of the area. Both triangles of an edge find the same halving point.
class PointSet {
 public:
  explicit PointSet(In<double> vertices) : area(vertices.rows, 0), part(vertices.rows, 0) {
    position.reserve(vertices.rows);
    for (int64_t v = 0; v < vertices.rows; ++v)
      position.push_back({vertices(v, 0), vertices(v, 1), vertices(v, 2)});
  }

  double length(int64_t a, int64_t b) const { return norm(minus(position[a], position[b])); }

  /// Gives a triangle's area to its corners, or halves it at its longest edge if that is too long.
  void add(std::array<int64_t, 3> corner, double longest, int32_t of_triangle) {
    int edge = 0;
    double size = 0;
    for (int k = 0; k < 3; ++k)
      if (const double l = length(corner[k], corner[(k + 1) % 3]); l > size) {
        size = l;
        edge = k;
      }
    const int64_t a = corner[edge], b = corner[(edge + 1) % 3], c = corner[(edge + 2) % 3];
    if (size > longest) {
      const int64_t m = middle(a, b);
      add({a, m, c}, longest, of_triangle);
      add({m, b, c}, longest, of_triangle);
      return;
    }
    const Vec3 normal = cross(minus(position[b], position[a]), minus(position[c], position[a]));
    for (const int64_t p : corner) {
      area[p] += norm(normal) / 6;
      part[p] = of_triangle;
    }
  }

  std::vector<Vec3> position;
  std::vector<double> area;
  std::vector<int32_t> part;  ///< of the surface

 private:
  int64_t middle(int64_t a, int64_t b) {
    const auto [lower, upper] = std::minmax(a, b);
    const auto next = static_cast<int64_t>(position.size());
    const auto [place, added] =
        middles_.try_emplace(static_cast<uint64_t>(lower) << 32 | upper, next);
    if (added) {
      position.push_back(scaled(plus(position[lower], position[upper]), 0.5));
      area.push_back(0);
      part.push_back(0);
    }
    return place->second;
  }

  std::unordered_map<uint64_t, int64_t> middles_;
};

}  // namespace

SurfacePoints surface_points(const VoxelGrid& grid, const Surface& surface) {
  ELASTOGEN_CHECK(surface.vertices.cols() == 3, "vertices must be (vertices, 3)");
  PointSet set(surface.vertices);
  for (int64_t t = 0; t < surface.triangles.rows(); ++t) {
    const std::array<int64_t, 3> corner = {surface.triangles(t, 0), surface.triangles(t, 1),
                                           surface.triangles(t, 2)};
    double longest = 0;
    for (int k = 0; k < 3; ++k)
      longest = std::max(longest, set.length(corner[k], corner[(k + 1) % 3]));
    const int32_t part = surface.part.empty() ? 0 : surface.part(t);
    if (part >= 0) set.add(corner, longest > grid.h ? grid.h / 2 : grid.h, part);
  }

  // points that represent some area
  const auto count =
      std::count_if(set.area.begin(), set.area.end(), [](double a) { return a > 0; });
  SurfacePoints points;
  points.area = Array<double>(count);
  points.position = Array<double>(count, 3);
  Array<int32_t> parts(count);
  int64_t p = 0;
  for (size_t i = 0; i < set.area.size(); ++i) {
    if (!(set.area[i] > 0)) continue;
    points.area(p) = set.area[i];
    parts(p) = set.part[i];
    std::copy(set.position[i].begin(), set.position[i].end(), points.position.row(p++));
  }
  Embedding embedding = embed(grid, points.position, parts);
  points.voxel = std::move(embedding.voxel);
  points.weights = std::move(embedding.weights);
  return points;
}

}  // namespace elastogen
