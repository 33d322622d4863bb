// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/fem/extrude.hpp"

#include "tests/io/test_files.hpp"
#include "tests/io/tets/tet_checks.hpp"

#include <cmath>

namespace elastogen::fem {
namespace {

using test::edge_count, test::error_of, test::expect_says, test::faces, test::determinants;

/// Cook's membrane [mm] (Cook 1974): area (44 + 16) / 2 * 48.
constexpr std::array<Vec2, 4> kCook = {{{0, 0}, {48, 44}, {48, 60}, {0, 44}}};

/// Six times the volume of hexahedra, by the Jacobian of their trilinear map at 2x2x2 Gauss points,
/// which is exact, and its least value there.
test::Determinants hex_determinants(const ElementMesh& mesh) {
  test::Determinants all;
  for (int64_t e = 0; e < mesh.elements.rows(); ++e) {
    double volume = 0;
    for (int q = 0; q < 8; ++q) {
      Vec3 slope[3] = {};
      for (int c = 0; c < 8; ++c)
        for (int d = 0; d < 3; ++d) {
          double weight = c >> d & 1 ? 1 : -1;
          for (int o = 0; o < 3; ++o) {
            const double s = 0.5 + (q >> o & 1 ? 0.5 : -0.5) / std::sqrt(3.);
            if (o != d) weight *= c >> o & 1 ? s : 1 - s;
          }
          const Vec3 x = test::place(mesh.rest, mesh.elements(e, c));
          slope[d] = plus(slope[d], scaled(x, weight));
        }
      const double J = dot(slope[0], cross(slope[1], slope[2]));
      all.least = std::min(all.least, J);
      volume += J / 8;
    }
    all.sum += 6 * volume;
  }
  return all;
}

/// Faces on the border of nx x ny x nz cells, two triangles each.
int64_t border_triangles(int64_t nx, int64_t ny, int64_t nz) {
  return 4 * (nx * ny + ny * nz + nz * nx);
}

TEST(Extrude, GradedPlanesGrowGeometrically) {
  const std::vector<double> even = graded(4, -1, 1);
  EXPECT_EQ(even, (std::vector<double>{-1, -0.5, 0, 0.5, 1}));
  const std::vector<double> planes = graded(4, 0, 15, 8);  // 1, 2, 4, 8
  const double expected[] = {0, 1, 3, 7, 15};
  for (size_t k = 0; k < 5; ++k) EXPECT_NEAR(planes[k], expected[k], 1e-14);
  EXPECT_EQ(graded(1, 2, 3, 7), (std::vector<double>{2, 3}));
}

TEST(Extrude, BoxTetsFillTheBoxAndConform) {
  // all planes are exact in binary
  const ElementMesh mesh = box_tets(3, 2, 4, {-1, 0, 2}, {0.5, 0.5, 4});
  EXPECT_EQ(mesh.elements.rows(), 6 * 24);
  EXPECT_EQ(mesh.rest.rows(), 4 * 3 * 5);
  EXPECT_EQ(mesh.material, Array<int32_t>(144));
  const double cell = 0.5 * 0.25 * 0.5;
  EXPECT_EQ(determinants(mesh).sum, 6 * 24 * cell);
  EXPECT_EQ(determinants(mesh).least, cell);
  EXPECT_EQ(determinants(mesh).most, cell);
  const test::Faces f = faces(mesh);
  EXPECT_EQ(f.wrong, 0);
  EXPECT_EQ(f.border, border_triangles(3, 2, 4));
  // Euler: nodes - edges + faces - tetrahedra of a ball
  EXPECT_EQ(mesh.rest.rows() - edge_count(mesh) + f.inner + f.border - mesh.elements.rows(), 1);
}

TEST(Extrude, GradedBoxesKeepTheirPlanes) {
  const std::vector<double> x = graded(5, 0, 2, 10), y = {0, 0.1, 1}, z = graded(3, -1, 0, 0.2);
  const ElementMesh mesh = box_tets(x, y, z);
  for (int64_t n = 0; n < mesh.rest.rows(); ++n) {
    EXPECT_EQ(mesh.rest(n, 0), x[size_t(n % 6)]);
    EXPECT_EQ(mesh.rest(n, 1), y[size_t(n / 6 % 3)]);
    EXPECT_EQ(mesh.rest(n, 2), z[size_t(n / 18)]);
  }
  EXPECT_GT(determinants(mesh).least, 0);
  EXPECT_NEAR(determinants(mesh).sum, 12, 1e-14);  // measured 3.6e-15
}

TEST(Extrude, CooksMembraneHasItsAreaAndCorners) {
  const double thickness = 2.5, volume = 1440 * thickness;
  for (const Element element :
       {Element::kTet4, Element::kTet10, Element::kTet10Bbar, Element::kHex, Element::kHexBbar}) {
    const bool is_hex = element == Element::kHex || element == Element::kHexBbar;
    const ElementMesh mesh = extruded_quadrilateral(kCook, thickness, 6, 4, 3, element);
    ASSERT_EQ(mesh.element, element);
    ASSERT_EQ(mesh.elements.rows(), is_hex ? 72 : 432);
    ASSERT_EQ(mesh.material.rows(), mesh.elements.rows());
    const test::Determinants v = is_hex ? hex_determinants(mesh) : determinants(mesh);
    EXPECT_GT(v.least, 0);
    EXPECT_NEAR(v.sum / (6 * volume), 1, 1e-14);  // measured 4.4e-16 with kTet4

    const int64_t corner[4] = {0, 6, 6 + 7 * 4, 7 * 4}, layer = 7 * 5;
    for (int64_t c = 0; c < 4; ++c)
      for (const int64_t k : {0, 3}) {
        const Vec3 x = test::place(mesh.rest, int32_t(corner[c] + layer * k));
        EXPECT_EQ(x, (Vec3{kCook[size_t(c)][0], kCook[size_t(c)][1], k == 0 ? 0 : thickness}));
      }
  }
}

TEST(Extrude, TetrahedraOfAQuadrilateralConform) {
  const ElementMesh mesh = extruded_quadrilateral(kCook, 1, 5, 3, 2, Element::kTet4);
  const test::Faces f = faces(mesh);
  EXPECT_EQ(f.wrong, 0);
  EXPECT_EQ(f.border, border_triangles(5, 3, 2));
  const ElementMesh curved = extruded_quadrilateral(kCook, 1, 5, 3, 2, Element::kTet10);
  EXPECT_EQ(curved.rest.rows(), mesh.rest.rows() + edge_count(mesh));
  for (int64_t e = 0; e < curved.elements.rows(); ++e) {
    const Vec3 a = test::place(curved.rest, curved.elements(e, 1)),
               b = test::place(curved.rest, curved.elements(e, 3)),
               middle = test::place(curved.rest, curved.elements(e, 8));
    EXPECT_LT(norm(minus(scaled(plus(a, b), 0.5), middle)), 1e-14);
  }
}

TEST(Extrude, HexahedraHaveTheirCornersInTheOrderOfVoxels) {
  const ElementMesh mesh =
      extruded_quadrilateral({{{0, 0}, {2, 0}, {2, 3}, {0, 3}}}, 4, 2, 3, 4, Element::kHex);
  for (int64_t e = 0; e < mesh.elements.rows(); ++e) {
    const int64_t at[3] = {e % 2, e / 2 % 3, e / 6};
    for (int c = 0; c < 8; ++c)
      for (int d = 0; d < 3; ++d)
        EXPECT_EQ(mesh.rest(mesh.elements(e, c), d), double(at[d] + (c >> d & 1)));
  }
}

TEST(Extrude, RefusesWhatCannotBe) {
  const auto says = [](const std::function<void()>& call, const std::string& part) {
    expect_says(error_of(call, ErrorKind::kUsage), part);
  };
  const std::array<Vec2, 4> clockwise = {{{0, 0}, {0, 1}, {1, 1}, {1, 0}}};
  const std::array<Vec2, 4> arrow = {{{0, 0}, {2, 0}, {0.5, 0.5}, {0, 2}}};
  const std::array<Vec2, 4> bow = {{{0, 0}, {1, 1}, {1, 0}, {0, 1}}};
  const std::array<Vec2, 4> infinite = {{{0, 0}, {1, 0}, {1, HUGE_VAL}, {0, 1}}};
  for (const auto& corners : {clockwise, arrow, bow, infinite})
    says([&] { extruded_quadrilateral(corners, 1, 1, 1, 1, Element::kHex); }, "convex");
  says([] { extruded_quadrilateral(kCook, 0, 1, 1, 1, Element::kHex); }, "thickness");
  says([] { extruded_quadrilateral(kCook, NAN, 1, 1, 1, Element::kHex); }, "thickness");
  says([] { extruded_quadrilateral(kCook, 1, 1, 0, 1, Element::kHex); }, "1 x 0 x 1");
  says([] { extruded_quadrilateral(kCook, 1, 1 << 30, 1 << 30, 1 << 30, Element::kHex); },
       "more nodes than 32 bits");
  says([] { extruded_quadrilateral(kCook, 1, 1, 1, 1, Element::kVoxel); }, "voxels are cubes");
  says([] { box_tets({0, 1}, {0}, {0, 1}); }, "1 x 0 x 1");
  says([] { box_tets({}, {0, 1}, {0, 1}); }, "-1 x 1 x 1");
  says([] { box_tets({0, 1}, {0, 0}, {0, 1}); }, "plane 1 of axis y");
  says([] { box_tets({0, 1}, {0, 1}, {NAN, 1}); }, "plane 0 of axis z");
  says([] { graded(0, 0, 1); }, "0 cells from 0 to 1");
  says([] { graded(2, 1, 1); }, "lower < upper");
  says([] { graded(2, 0, 1, 0); }, "a positive ratio");
}

}  // namespace
}  // namespace elastogen::fem
