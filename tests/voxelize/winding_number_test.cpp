// SPDX-License-Identifier: Apache-2.0
#include "voxelize/winding_number.hpp"

#include "tests/voxelize/shapes.hpp"

#include <gtest/gtest.h>

#include <random>

namespace elastogen {
namespace {

using namespace test;

std::vector<WindingNumber::Triangle> triangles_of(const Soup& soup) {
  std::vector<WindingNumber::Triangle> result;
  for (const auto& [a, b, c] : soup.triangles)
    result.push_back({{soup.vertices[a], soup.vertices[b], soup.vertices[c]}});
  return result;
}

TEST(WindingNumber, OfATriangleIsItsSolidAngle) {
  // one of the eight octants
  const WindingNumber::Triangle octant = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  EXPECT_NEAR(winding(octant, {0, 0, 0}), 1.0 / 8, 1e-15);
  EXPECT_NEAR(winding({{{1, 0, 0}, {0, 0, 1}, {0, 1, 0}}}, {0, 0, 0}), -1.0 / 8, 1e-15);
}

TEST(WindingNumber, OfAClosedSurfaceIsOneInsideAndZeroOutside) {
  const WindingNumber w(triangles_of(sphere(1, {}, 4)));
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(-2, 2);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 p = {place(random), place(random), place(random)};
    if (std::abs(norm(p) - 1) > 0.01) {
      ASSERT_NEAR(w(p), norm(p) < 1, 0.02);
    }
  }
}

TEST(WindingNumber, OfTheTreeAgreesWithTheSumOverAllTriangles) {
  Soup soup = sphere(1, {}, 4);
  soup.triangles.resize(soup.triangles.size() / 2);
  const auto triangles = triangles_of(soup);
  const WindingNumber w(triangles);
  std::mt19937 random(2);
  std::uniform_real_distribution<double> place(-2, 2);
  for (int i = 0; i < 500; ++i) {
    const Vec3 p = {place(random), place(random), place(random)};
    double sum = 0;
    for (const auto& triangle : triangles) sum += winding(triangle, p);
    ASSERT_NEAR(w(p), sum, 0.01);
  }
}

TEST(WindingNumber, OfNothingIsZero) {
  EXPECT_EQ(WindingNumber({})({1, 2, 3}), 0);
}

}  // namespace
}  // namespace elastogen
