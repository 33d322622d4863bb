// SPDX-License-Identifier: Apache-2.0
// Surfaces whose volume and inside are known.

#pragma once

#include "core/vec3.hpp"
#include "voxelize/voxelize.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <string>

namespace elastogen::test {

struct Soup {
  std::vector<Vec3> vertices;
  std::vector<std::array<int, 3>> triangles;

  /// Joins another one.
  void add(const Soup& other) {
    const auto first = static_cast<int>(vertices.size());
    vertices.insert(vertices.end(), other.vertices.begin(), other.vertices.end());
    for (const auto& [a, b, c] : other.triangles)
      triangles.push_back({a + first, b + first, c + first});
  }
  void map(const std::function<Vec3(const Vec3&)>& f) {
    for (Vec3& p : vertices) p = f(p);
  }
  void turn(size_t t) { std::swap(triangles[t][1], triangles[t][2]); }
  double volume() const {
    double sum = 0;
    for (const auto& [a, b, c] : triangles)
      sum += dot(vertices[a], cross(vertices[b], vertices[c])) / 6;
    return sum;
  }
  double area() const {
    double sum = 0;
    for (const auto& [a, b, c] : triangles)
      sum += norm(cross(minus(vertices[b], vertices[a]), minus(vertices[c], vertices[a]))) / 2;
    return sum;
  }
  Surface surface() const {
    Surface result;
    result.vertices = Array<double>(static_cast<int64_t>(vertices.size()), 3);
    result.triangles = Array<int32_t>(static_cast<int64_t>(triangles.size()), 3);
    result.material = Array<int32_t>(result.triangles.rows());
    for (size_t v = 0; v < vertices.size(); ++v)
      std::copy(vertices[v].begin(), vertices[v].end(), result.vertices.row(v));
    for (size_t t = 0; t < triangles.size(); ++t)
      for (int k = 0; k < 3; ++k) {
        result.triangles(t, k) = triangles[t][k];
        result.box.add(vertices[triangles[t][k]]);
      }
    return result;
  }
};

inline Soup box(const Vec3& lower, const Vec3& upper) {
  Soup soup;
  for (int c = 0; c < 8; ++c)
    soup.vertices.push_back(
        {c & 1 ? upper[0] : lower[0], c & 2 ? upper[1] : lower[1], c & 4 ? upper[2] : lower[2]});
  soup.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return soup;
}

/// A subdivided octahedron; 8 * 4^level triangles.
inline Soup sphere(double radius, const Vec3& centre, int level) {
  Soup soup;
  soup.vertices = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  soup.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                    {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  // cut each triangle into four; the middles of its edges move onto the sphere
  for (int l = 0; l < level; ++l) {
    std::map<std::pair<int, int>, int> middle;
    const auto halve = [&](int a, int b) {
      const auto [place, added] =
          middle.try_emplace(std::minmax(a, b), static_cast<int>(soup.vertices.size()));
      if (added) {
        const Vec3 p = plus(soup.vertices[a], soup.vertices[b]);
        soup.vertices.push_back(scaled(p, 1 / norm(p)));
      }
      return place->second;
    };
    std::vector<std::array<int, 3>> finer;
    for (const auto& [a, b, c] : soup.triangles) {
      const int ab = halve(a, b), bc = halve(b, c), ca = halve(c, a);
      for (const std::array<int, 3>& t :
           {std::array{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}})
        finer.push_back(t);
    }
    soup.triangles = finer;
  }
  soup.map([&](const Vec3& p) { return plus(centre, scaled(p, radius)); });
  return soup;
}

/// A flat square sheet of n x n cells in z = 0.
inline Soup sheet(double size, int n) {
  Soup soup;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) soup.vertices.push_back({size * i / n, size * j / n, 0});
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int v = i + (n + 1) * j;
      soup.triangles.push_back({v, v + 1, v + n + 1});
      soup.triangles.push_back({v + 1, v + n + 2, v + n + 1});
    }
  return soup;
}

/// Turned by an angle about (1, 2, 3).
inline Vec3 turned(const Vec3& p, double angle) {
  const Vec3 axis = scaled({1, 2, 3}, 1 / std::sqrt(14.0));
  return plus(plus(scaled(p, std::cos(angle)), scaled(cross(axis, p), std::sin(angle))),
              scaled(axis, dot(axis, p) * (1 - std::cos(angle))));
}

/// Sum over the voxels of fill h^3.
inline double mass(const VoxelGrid& grid) {
  double sum = 0;
  for (int64_t v = 0; v < grid.voxel_count(); ++v) sum += grid.fill(v);
  return sum * grid.h * grid.h * grid.h;
}

inline bool has_finding(const VoxelizeReport& report, const std::string& what) {
  return std::any_of(report.findings.begin(), report.findings.end(),
                     [&](const Finding& f) { return f.what == what; });
}

inline void expect_same(const VoxelGrid& a, const VoxelGrid& b) {
  EXPECT_TRUE(a.voxel_coord == b.voxel_coord);
  EXPECT_TRUE(a.fill == b.fill);
  EXPECT_TRUE(a.shape_mean == b.shape_mean);
  EXPECT_EQ(a.volume, b.volume);
}

/// Shape means are means: none negative, and each voxel's sum is 1.
inline void expect_means(const VoxelGrid& grid) {
  for (int64_t v = 0; v < grid.voxel_count(); ++v) {
    double sum = 0;
    for (int c = 0; c < 8; ++c) {
      ASSERT_GE(grid.shape_mean(v, c), 0);
      sum += grid.shape_mean(v, c);
    }
    ASSERT_NEAR(sum, 1, 1e-15);
    ASSERT_GE(grid.fill(v), 0.02);
    ASSERT_LE(grid.fill(v), 1);
  }
}

}  // namespace elastogen::test
