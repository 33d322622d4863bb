// SPDX-License-Identifier: Apache-2.0
#include "io/weld.hpp"

#include "tests/io/cube_asset.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace elastogen {
namespace {

using test::corners, test::cube;

TEST(Weld, JoinsBelowTheToleranceAndNotAbove) {
  // a soup of the cube's triangles, each corner moved by a share of the edge
  for (const auto& [move, vertices] : {std::pair{1e-7, 8}, std::pair{1e-5, 36}}) {
    const Asset clean = cube(2e-3, {3, -4, 5});
    Asset soup = clean;
    Mesh& mesh = soup.meshes[0];
    mesh.position.clear();
    mesh.position_of.clear();
    for (int32_t k = 0; k < 36; ++k) {
      Vec3 x = clean.meshes[0].position[size_t(clean.meshes[0].groups[0].corner[size_t(k)])];
      for (int d = 0; d < 3; ++d) x[d] += 2e-3 * move * std::cos(7. * k + 2. * d);
      mesh.position.push_back(x);
      mesh.position_of.push_back(k);
      corners(soup)[size_t(k)] = k;
    }
    const WeldedMesh w = weld(pose_surface(soup));
    EXPECT_EQ(w.vertices.rows(), vertices);
    EXPECT_EQ(w.merged, 36 - vertices);
    EXPECT_EQ(w.closed(), vertices == 8);
  }
}

TEST(Weld, FindsTheSamePairsAsAllAgainstAll) {
  // points on a line, 0.4 tolerances apart: each joins the nearest earlier one that stayed
  Surface surface;
  const int n = 400;
  surface.vertices = Array<double>(n + 2, 3);
  surface.triangles = Array<int32_t>(n, 3);
  const double tolerance = 1e-3;
  for (int i = 0; i < n; ++i)
    for (int d = 0; d < 3; ++d)
      surface.vertices(i, d) = 0.01 * std::sin(12.9898 * (i + 1) * (d + 1));
  for (int d = 0; d < 3; ++d) surface.vertices(n, d) = 0.5, surface.vertices(n + 1, d) = -0.5;
  for (int i = 0; i < n; ++i)
    surface.triangles(i, 0) = i, surface.triangles(i, 1) = n, surface.triangles(i, 2) = n + 1;
  for (int i = 0; i < n + 2; ++i)
    surface.box.add({surface.vertices(i, 0), surface.vertices(i, 1), surface.vertices(i, 2)});

  std::vector<int> kept, expected;
  for (int i = 0; i < n + 2; ++i) {
    int nearest = -1;
    double best = tolerance;  // the longest edge is 1
    for (size_t k = 0; k < kept.size(); ++k) {
      double d2 = 0;
      for (int d = 0; d < 3; ++d)
        d2 += std::pow(surface.vertices(i, d) - surface.vertices(kept[k], d), 2);
      if (std::sqrt(d2) < best) best = std::sqrt(d2), nearest = int(k);
    }
    expected.push_back(nearest >= 0 ? nearest : int(kept.size()));
    if (nearest < 0) kept.push_back(i);
  }
  const WeldedMesh w = weld(surface, tolerance);
  EXPECT_EQ(w.welded_of, std::vector<int32_t>(expected.begin(), expected.end()));
  EXPECT_GT(w.merged, 10);
  EXPECT_LT(w.merged, n - 10);
}

TEST(Weld, WallsThatTouchKeepTheSurfaceBalanced) {
  // two cubes side by side: welded, the square between them is there twice, once in each sense
  Asset asset = cube();
  asset.nodes.push_back({"beside", -1, kIdentity4, 0});
  asset.nodes[1].matrix[12] = 1;
  for (size_t k = 24; k < 30; k += 3) {  // the cube's diagonals at x = 0 as at x = 1
    const std::vector<int32_t> turned = {1, 3, 7, 1, 7, 5};
    for (size_t c = 0; c < 3; ++c) corners(asset)[30 + k - 24 + c] = turned[k - 24 + c];
  }
  const WeldedMesh w = weld(pose_surface(asset));
  EXPECT_EQ(w.opposite_pairs, 2);
  EXPECT_EQ(w.triangles.rows(), 24);
  EXPECT_TRUE(w.balanced());
  EXPECT_EQ(w.nonmanifold_edges, 5);  // the rim of the square and its diagonal
  EXPECT_NEAR(w.volume, 2, 1e-14);
}

TEST(Weld, ASheetDrawnFromBothSidesIsBalancedAndHasNoVolume) {
  Asset asset = cube();
  corners(asset) = {0, 1, 3, 0, 3, 2, 3, 1, 0, 2, 3, 0};
  const WeldedMesh w = weld(pose_surface(asset));
  EXPECT_EQ(w.opposite_pairs, 2);
  EXPECT_EQ(w.triangles.rows(), 4);
  EXPECT_TRUE(w.balanced());
  EXPECT_EQ(w.volume, 0);
}

TEST(Weld, ASurfaceWithoutTrianglesIsNotClosed) {
  const WeldedMesh w = weld(Surface{});
  EXPECT_FALSE(w.closed() || w.balanced());
}

TEST(Weld, AMoebiusBandIsUnbalanced) {
  // ten quads, the last glued upside down
  Surface surface;
  surface.vertices = Array<double>(20, 3);
  surface.triangles = Array<int32_t>(20, 3);
  for (int i = 0; i < 10; ++i)
    for (int s = 0; s < 2; ++s) {
      const double a = 0.2 * M_PI * i, r = 2 + (s ? 0.5 : -0.5) * std::cos(0.5 * a);
      surface.vertices(2 * i + s, 0) = r * std::cos(a);
      surface.vertices(2 * i + s, 1) = r * std::sin(a);
      surface.vertices(2 * i + s, 2) = (s ? 0.5 : -0.5) * std::sin(0.5 * a);
      surface.box.add({r * std::cos(a), r * std::sin(a), 0.5});
    }
  for (int i = 0; i < 10; ++i) {
    const int p = 2 * i, q = p + 1, r = i < 9 ? p + 2 : 1, s = i < 9 ? p + 3 : 0;
    const int corner[6] = {p, q, r, r, q, s};
    for (int k = 0; k < 6; ++k) surface.triangles(2 * i + k / 3, k % 3) = corner[k];
  }
  const WeldedMesh w = weld(surface);
  EXPECT_EQ(w.border_edges, 20);
  EXPECT_EQ(w.turned_edges, 1);
  EXPECT_EQ(w.pieces, 1);
  EXPECT_FALSE(w.closed() || w.balanced());
}

}  // namespace
}  // namespace elastogen
