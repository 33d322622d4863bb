// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/fem/tet_surface.hpp"

#include "mpm_fem/contact/collider_contact.hpp"
#include "mpm_fem/fem/extrude_polygon.hpp"
#include "mpm_fem/fem/voxel_tets.hpp"
#include "tests/io/test_files.hpp"
#include "tests/io/tets/tet_checks.hpp"

#include <cmath>
#include <map>

namespace elastogen::fem {
namespace {

using test::error_of, test::expect_says;

const std::vector<Vec2> kEll = {{0, 0}, {4, 0}, {4, 1}, {1, 1}, {1, 3}, {0, 3}};  // area 6

/// Volume that triangles bound, positive where they are seen counterclockwise from outside [m^3].
double enclosed(const ElementMesh& mesh, const Array<int32_t>& triangles) {
  double six = 0;
  for (int64_t t = 0; t < triangles.rows(); ++t) {
    Vec3 x[3];
    for (int c = 0; c < 3; ++c) x[c] = test::place(mesh.rest, triangles(t, c));
    six += dot(x[0], cross(x[1], x[2]));
  }
  return six / 6;
}

/// Edges of triangles that do not occur exactly once in each direction.
int64_t open_edges(const Array<int32_t>& triangles) {
  std::map<std::pair<int32_t, int32_t>, int> sides;
  for (int64_t t = 0; t < triangles.rows(); ++t)
    for (int c = 0; c < 3; ++c) ++sides[{triangles(t, c), triangles(t, (c + 1) % 3)}];
  int64_t open = 0;
  for (const auto& [edge, count] : sides)
    open += count != 1 || !sides.contains({edge.second, edge.first});
  return open;
}

TEST(TetSurface, IsClosedAndSeenFromOutside) {
  for (const Element element : {Element::kTet4, Element::kTet10}) {
    const ElementMesh mesh = extruded_polygon(kEll, 0.5, 1, 2, element);
    const Array<int32_t> triangles = outer_triangles(mesh);
    const int64_t faces = 2 * 16 + 2 * 12 * 2;  // bottom and top, two a side of a prism
    EXPECT_EQ(triangles.rows(), faces * (element == Element::kTet4 ? 1 : 4));
    EXPECT_EQ(open_edges(triangles), 0);
    EXPECT_NEAR(enclosed(mesh, triangles), 3, 1e-14);  // area 6, thickness 0.5
  }
}

TEST(TetSurface, KeepsTheOrderOfTheTetrahedra) {
  ElementMesh mesh;
  mesh.element = Element::kTet4;
  mesh.rest = Array<double>(4, 3);
  mesh.rest(1, 0) = mesh.rest(2, 1) = mesh.rest(3, 2) = 1;
  mesh.elements = Array<int32_t>(1, 4);
  for (int c = 0; c < 4; ++c) mesh.elements(0, c) = c;
  const Array<int32_t> triangles = outer_triangles(mesh);
  EXPECT_EQ(triangles.rows(), 4);
  for (int c = 0; c < 3; ++c) EXPECT_EQ(triangles(0, c), c + 1);  // the face that lacks corner 0
  EXPECT_NEAR(enclosed(mesh, triangles), 1. / 6, 1e-15);
  EXPECT_NEAR(mean_edge(mesh), 1, 1e-15);
}

TEST(TetSurface, MeanEdgeIsThatOfTheVoxelsThatWereCut) {
  const ElementMesh cells = box_tets(3, 2, 4, {0, 0, 0}, {0.75, 0.5, 1});
  EXPECT_NEAR(mean_edge(cells), 0.25, 1e-15);
  EXPECT_NEAR(mean_edge(quadratic(cells)), 0.25, 1e-15);
}

TEST(TetSurface, TakesNoneAndRefusesHexahedra) {
  ElementMesh mesh;
  mesh.element = Element::kTet4;
  mesh.elements = Array<int32_t>(0, 4);
  EXPECT_EQ(outer_triangles(mesh).rows(), 0);
  mesh.elements = Array<int32_t>(1, 8);
  expect_says(error_of([&] { outer_triangles(mesh); }, ErrorKind::kUsage), "got 8 columns");
  expect_says(error_of([&] { mean_edge(mesh); }, ErrorKind::kUsage), "got 8 columns");
}

TEST(TetSurface, NodesInContactAreAsStiffAsTheStiffestElement) {
  ElementMesh mesh = box_tets(2, 1, 1, {0, 0, 0}, {1, 0.5, 0.5});
  for (int64_t e = 6; e < 12; ++e) mesh.material(e) = 1;
  Scene scene;
  scene.materials = {Material{}, Material{}};
  scene.materials[0].young = 1e4;
  scene.materials[1].young = 1e6;
  scene.grid.h = mean_edge(mesh);
  scene.dt = 0.01;
  Array<int32_t> nodes(3);  // at x = 0, 0.5 and 1
  for (int n = 0; n < 3; ++n) nodes(n) = n;
  scene.surface.position = Array<double>(3, 3);
  for (int n = 0; n < 3; ++n) scene.surface.position(n, 0) = 0.5 * n;
  scene.surface.area = Array<double>(3);
  scene.surface.area.fill(0.25);
  const ContactPoints points = node_contact(scene, mesh, nodes);
  EXPECT_NEAR(points.layer, 0.125, 1e-15);
  EXPECT_NEAR(points.slip_range, 1e-3 * std::sqrt(9.81) * 0.01, 1e-18);
  for (int n = 0; n < 3; ++n) {
    EXPECT_EQ(points.nodes(n), n);
    EXPECT_EQ(points.weights(n), 1);
    EXPECT_NEAR(points.stiffness(n), (n == 0 ? 1e4 : 1e6) * 0.125 * 0.125 / 0.5, 1e-9);
  }
}

}  // namespace
}  // namespace elastogen::fem
