// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/fem/extrude_polygon.hpp"

#include "tests/io/test_files.hpp"
#include "tests/io/tets/tet_checks.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace elastogen::fem {
namespace {

using test::edge_count, test::error_of, test::expect_says, test::faces, test::determinants;

using Polygon = std::vector<Vec2>;

const Polygon kL = {{0, 0}, {4, 0}, {4, 1}, {1, 1}, {1, 3}, {0, 3}};  // area 6

/// Ten corners on two circles of radius 2 and 1: area 10 * 2 * 1 * sin(36 deg) / 2.
Polygon star() {
  Polygon corners;
  for (int k = 0; k < 10; ++k) {
    const double angle = k * std::numbers::pi / 5, radius = k % 2 ? 1 : 2;
    corners.push_back({radius * std::cos(angle), radius * std::sin(angle)});
  }
  return corners;
}

/// By the shoelace formula, positive counterclockwise.
double area_of(const Polygon& p) {
  double twice = 0;
  for (size_t k = 0; k < p.size(); ++k) {
    const Vec2 &a = p[k], &b = p[(k + 1) % p.size()];
    twice += a[0] * b[1] - a[1] * b[0];
  }
  return twice / 2;
}

/// Whether a point lies within rounding of an edge of the polygon.
bool on_border(const Polygon& p, const Vec3& x) {
  for (size_t k = 0; k < p.size(); ++k) {
    const Vec2 &a = p[k], &b = p[(k + 1) % p.size()];
    const double ab = std::hypot(b[0] - a[0], b[1] - a[1]);
    const double ax = std::hypot(x[0] - a[0], x[1] - a[1]),
                 xb = std::hypot(b[0] - x[0], b[1] - x[1]);
    if (ax + xb - ab < 1e-12) return true;
  }
  return false;
}

/// Volume, orientation, conformity, topology of a ball, and the border of an extruded polygon.
void check(const Polygon& polygon, int refinements, int layers) {
  const double thickness = 0.5;
  const ElementMesh mesh =
      extruded_polygon(polygon, thickness, refinements, layers, Element::kTet4);
  const auto corners = int64_t(polygon.size());
  const int64_t triangles = (corners - 2) << (2 * refinements), rim = corners << refinements;
  ASSERT_EQ(mesh.elements.rows(), 3 * triangles * layers);
  const test::Determinants six = determinants(mesh);
  EXPECT_GT(six.least, 0);
  EXPECT_NEAR(six.sum / (6 * thickness * std::abs(area_of(polygon))), 1, 1e-13);
  const test::Faces f = faces(mesh);
  EXPECT_EQ(f.wrong, 0);
  EXPECT_EQ(f.border, 2 * triangles + 2 * rim * layers);  // bottom and top; two a side of a prism
  EXPECT_EQ(mesh.rest.rows() - edge_count(mesh) + f.inner + f.border - mesh.elements.rows(), 1);
  int64_t at_rim = 0;
  for (int64_t n = 0; n < mesh.rest.rows(); ++n)
    at_rim += on_border(polygon, test::place(mesh.rest, int32_t(n)));
  EXPECT_EQ(at_rim, rim * (layers + 1));
}

TEST(ExtrudePolygon, FillsConcaveOutlinesAndConforms) {
  for (const Polygon& polygon : {kL, star(), Polygon{{0, 0}, {2, 0}, {0, 1}}})
    for (int refinements = 0; refinements <= 2; ++refinements)
      for (const int layers : {1, 3}) {
        SCOPED_TRACE(polygon.size());
        check(polygon, refinements, layers);
      }
}

TEST(ExtrudePolygon, TakesEitherWayRound) {
  Polygon turned = kL;
  std::reverse(turned.begin(), turned.end());
  check(turned, 1, 2);
  const ElementMesh mesh = extruded_polygon(turned, 1, 0, 1, Element::kTet4);
  for (size_t k = 0; k < turned.size(); ++k)
    EXPECT_EQ(test::place(mesh.rest, int32_t(k)), (Vec3{turned[k][0], turned[k][1], 0}));
}

TEST(ExtrudePolygon, KeepsCornersWithinStraightEdges) {
  check({{0, 0}, {1, 0}, {2, 0}, {2, 1}, {2, 2}, {0, 2}}, 1, 1);
  check({{0, 0}, {1, 0}, {2, 0}, {3, 0}, {0, 3}}, 0, 1);
}

/// Combs and a spiral, whose reflex corners make most candidates no ears.
TEST(ExtrudePolygon, CutsCombsAndSpirals) {
  Polygon comb = {{0, -1}, {16, -1}};
  for (int k = 8; k-- > 0;) {
    comb.push_back({2. * k + 2, 4});
    comb.push_back({2. * k + 1, 0.25});
  }
  comb.push_back({0, 4});
  check(comb, 0, 1);
  Polygon spiral;
  for (int k = 0; k <= 40; ++k)
    spiral.push_back({(1 + 0.1 * k) * std::cos(0.4 * k), (1 + 0.1 * k) * std::sin(0.4 * k)});
  for (int k = 40; k >= 0; --k)
    spiral.push_back({(1.4 + 0.1 * k) * std::cos(0.4 * k), (1.4 + 0.1 * k) * std::sin(0.4 * k)});
  check(spiral, 1, 1);
}

TEST(ExtrudePolygon, QuadraticNodesHalveTheEdges) {
  const ElementMesh linear = extruded_polygon(kL, 1, 1, 2, Element::kTet4);
  for (const Element element : {Element::kTet10, Element::kTet10Bbar}) {
    const ElementMesh mesh = extruded_polygon(kL, 1, 1, 2, element);
    EXPECT_EQ(mesh.element, element);
    EXPECT_EQ(mesh.rest.rows(), linear.rest.rows() + edge_count(linear));
    check_mesh(mesh);
  }
}

TEST(ExtrudePolygon, RefusesWhatCannotBeWithThePlace) {
  const auto says = [](const Polygon& polygon, const std::string& part) {
    expect_says(error_of([&] { polygon_mesh(polygon, 0); }, ErrorKind::kUsage), part);
  };
  says({{0, 0}, {1, 0}}, "three corners or more, got 2");
  says({{0, 0}, {1, 1}, {1, 0}, {0, 1}}, "from corner 0 and from 2 meet at (0.5, 0.5)");
  says({{0, 0}, {4, 0}, {4, 4}, {2, 0}, {0, 4}}, "from corner 0 and from 2 meet at (2, 0)");
  says({{0, 0}, {4, 0}, {4, 2}, {3, 0}, {2, 0}, {0, 2}}, "from corner 0 and from 2 meet at (3, 0)");
  says({{0, 0}, {1, 0}, {1, 0}, {0, 1}}, "corners 1 and 2 of the polygon are one place, (1, 0)");
  says({{0, 0}, {2, 0}, {1, 0}}, "turns back on itself at corner 1, (2, 0)");
  says({{0, 0}, {1, NAN}, {0, 1}}, "corner 1 of the polygon is not finite");
  const auto refuses = [](double thickness, int refinements, int layers, Element element,
                          const std::string& part) {
    const auto call = [&] { extruded_polygon(kL, thickness, refinements, layers, element); };
    expect_says(error_of(call, ErrorKind::kUsage), part);
  };
  refuses(0, 0, 1, Element::kTet4, "thickness");
  refuses(1, -1, 1, Element::kTet4, "refinements");
  refuses(1, 11, 1, Element::kTet4, "refinements");
  refuses(1, 0, 0, Element::kTet4, "at least one layer");
  refuses(1, 0, 1, Element::kHex, "not into hex");
  refuses(1, 5, 1 << 30, Element::kTet4, "more nodes than 32 bits");
}

}  // namespace
}  // namespace elastogen::fem
