// SPDX-License-Identifier: Apache-2.0
// Triangles that bound a solid fill it, whatever touches them and however badly they meet.

#include "tests/voxelize/shapes.hpp"
#include "voxelize/voxelize.hpp"

#include <random>

namespace elastogen {
namespace {

using test::Soup;

/// Every triangle with corners of its own, each moved by up to `noise` along every axis.
Soup loosened(const Soup& body, double noise) {
  std::mt19937 engine(7);
  std::uniform_real_distribution<double> shift(-noise, noise);
  Soup soup;
  for (const auto& triangle : body.triangles) {
    const auto first = int(soup.vertices.size());
    for (const int v : triangle) {
      Vec3 p = body.vertices[size_t(v)];
      for (double& x : p) x += shift(engine);
      soup.vertices.push_back(p);
    }
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  return soup;
}

/// A torus of radii 0.35 and 0.15, `n` segments around and across.
Soup torus(int n) {
  Soup soup;
  const auto turn = [n](int i) { return 2 * 3.14159265358979323846 * i / n; };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const double r = 0.35 + 0.15 * std::cos(turn(j));
      soup.vertices.push_back(
          {r * std::cos(turn(i)), r * std::sin(turn(i)), 0.15 * std::sin(turn(j))});
    }
  const auto at = [n](int i, int j) { return (i % n) * n + j % n; };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      soup.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      soup.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return soup;
}

double filled(const Soup& soup, int voxels) {
  VoxelizeOptions options;
  options.voxels = voxels;
  return test::mass(voxelize(soup.surface(), options).grid);
}

int64_t sheet_faces(const VoxelizeReport& report) {
  for (const Finding& f : report.findings)
    if (f.what == "sheet") return f.count;
  return 0;
}

TEST(Sheets, SoupsOfLooseTrianglesHaveTheVolumeOfTheBody) {
  const Soup bodies[] = {test::box({0, 0, 0}, {1, 1, 1}), test::box({0, 0, 0}, {1, 0.4, 0.2}),
                         test::sphere(0.5, {0, 0, 0}, 2), test::sphere(0.5, {0, 0, 0}, 4),
                         torus(20)};
  for (size_t b = 0; b < std::size(bodies); ++b)
    for (const double noise : {0.0, 1e-6, 1e-5, 1e-4, 1e-3})
      for (const int voxels : {24, 160}) {
        if (voxels == 160 && (noise != 1e-3 || b % 2 != 0 || b > 2)) continue;
        const double volume = bodies[b].volume();
        EXPECT_NEAR(filled(loosened(bodies[b], noise), voxels), volume, 0.02 * volume)
            << "body " << b << " noise " << noise << " voxels " << voxels;
      }
}

TEST(Sheets, ALoneTriangleIsALayer) {
  Soup soup;
  soup.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  soup.triangles = {{0, 1, 2}};
  VoxelizeOptions options;
  options.voxels = 20;
  const Voxelized v = voxelize(soup.surface(), options);
  EXPECT_TRUE(test::has_finding(v.report, "sheet"));
  for (int64_t i = 0; i < v.grid.voxel_count(); ++i) EXPECT_EQ(v.grid.fill(i), 1);
}

/// A strip from a to a + along, n squares long, twisted by half turns about its middle line.
Soup ribbon(const Vec3& a, const Vec3& along, double width, int n, int half_turns) {
  Soup soup;
  for (int i = 0; i <= n; ++i) {
    const double angle = 3.14159265358979323846 * half_turns * i / n;
    const Vec3 middle = plus(a, scaled(along, double(i) / n));
    const Vec3 side = {0, width / 2 * std::cos(angle), width / 2 * std::sin(angle)};
    soup.vertices.push_back(minus(middle, side));
    soup.vertices.push_back(plus(middle, side));
  }
  for (int i = 0; i < n; ++i) {
    soup.triangles.push_back({2 * i, 2 * i + 2, 2 * i + 1});
    soup.triangles.push_back({2 * i + 1, 2 * i + 2, 2 * i + 3});
  }
  return soup;
}

/// A Moebius band about `centre`, cut so that its seam is the edge from p to q.
Soup band(const Vec3& p, const Vec3& q, double radius, int n) {
  Soup soup;
  const Vec3 half = scaled(minus(q, p), 0.5), middle = plus(p, half);
  for (int i = 0; i < n; ++i) {
    const double a = 2 * 3.14159265358979323846 * i / n;
    // the circle leaves the edge along +x; the edge turns by half a turn in the plane of y and z
    const Vec3 centre = plus(middle, {radius * std::sin(a), 0, radius * (1 - std::cos(a))});
    const double c = std::cos(a / 2), s = std::sin(a / 2);
    const Vec3 side = {0, c * half[1] - s * half[2], s * half[1] + c * half[2]};
    soup.vertices.push_back(minus(centre, side));
    soup.vertices.push_back(plus(centre, side));
  }
  for (int i = 0; i < n; ++i) {
    const bool seam = i + 1 == n;
    const int a = 2 * i, b = a + 1, c = seam ? 1 : a + 2, d = seam ? 0 : a + 3;
    soup.triangles.push_back({a, c, b});
    soup.triangles.push_back({b, c, d});
  }
  return soup;
}

/// The box [0, 1]^3 with something added that touches it.
void expect_filled(const Soup& scrap, int voxels) {
  Soup soup = test::box({0, 0, 0}, {1, 1, 1});
  soup.add(scrap);
  VoxelizeOptions options;
  options.h = 1.0 / voxels;
  const Voxelized v = voxelize(soup.surface(), options);
  // a layer has the area at least, and cells on both sides of where it is oblique
  EXPECT_GT(test::mass(v.grid), 0.99) << voxels;
  EXPECT_LT(test::mass(v.grid), 1.01 + (3 * scrap.area() + 6.0 / voxels) / voxels) << voxels;
  for (int64_t i = 0; i < v.grid.voxel_count(); ++i) {
    Vec3 centre;
    bool inside = true;
    for (int d = 0; d < 3; ++d) {
      centre[size_t(d)] = v.grid.origin[size_t(d)] + v.grid.h * (v.grid.voxel_coord(i, d) + 0.5);
      inside &= std::abs(centre[size_t(d)] - 0.5) < 0.5 - 2 * v.grid.h;
    }
    if (!inside) continue;
    EXPECT_EQ(v.grid.fill(i), 1);
  }
}

TEST(Sheets, ABodyStaysFilledWhateverTouchesIt) {
  for (const int voxels : {12, 30}) {
    // a flap on an edge of the box, small and large, straight and twisted
    for (const double length : {0.05, 0.5, 3.0})
      for (const int half_turns : {0, 1, 2})
        expect_filled(ribbon({1, 0.5, 1}, {length, 0, 0}, 1, 8, half_turns), voxels);
    // one that shares a corner alone
    Soup corner;
    corner.vertices = {{1, 1, 1}, {1.6, 1, 1.3}, {1.2, 1.5, 1.2}};
    corner.triangles = {{0, 1, 2}};
    expect_filled(corner, voxels);
    // a ribbon that cannot be oriented, on an edge
    expect_filled(band({1, 0, 1}, {1, 1, 1}, 0.4, 24), voxels);
  }
}

TEST(Sheets, AWallInsideABodyChangesNothing) {
  Soup soup = test::box({0, 0, 0}, {1, 1, 1});
  // on two edges of the box, so that these have three faces
  soup.triangles.push_back({0, 1, 7});
  soup.triangles.push_back({0, 7, 6});
  EXPECT_NEAR(filled(soup, 20), 1, 1e-9);
  EXPECT_EQ(sheet_faces(voxelize(soup.surface()).report), 0);
}

TEST(Sheets, BoxesThatShareAFaceAreFilled) {
  Soup soup = test::box({0, 0, 0}, {1, 1, 1});
  Soup other = test::box({1, 0, 0}, {2, 1, 1});
  other.triangles.erase(other.triangles.begin() + 8, other.triangles.begin() + 10);
  soup.add(other);
  EXPECT_NEAR(filled(soup, 40), 2, 0.01);
}

TEST(Sheets, TwoParallelSheetsAreAPlateWhereTheyBoundOne) {
  // 0.1 apart, wound away from each other: the rim is open
  Soup plate = test::box({0, 0, 0}, {1, 1, 0.1});
  plate.triangles.erase(plate.triangles.begin() + 4, plate.triangles.end());
  EXPECT_NEAR(filled(plate, 60), 0.1, 0.01);
  // wound in one sense, the two bound nothing
  plate.turn(0);
  plate.turn(1);
  VoxelizeOptions options;
  options.voxels = 60;
  EXPECT_EQ(sheet_faces(voxelize(plate.surface(), options).report), 4);
}

}  // namespace
}  // namespace elastogen
