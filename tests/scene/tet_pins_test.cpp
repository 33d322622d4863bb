// SPDX-License-Identifier: Apache-2.0
// Pins and moves of tetrahedra that are cut from voxels.
#include "scene/tet_pins.hpp"

#include "core/vec3.hpp"
#include "mpm_fem/fem/elastic_body.hpp"
#include "scene/boundary.hpp"
#include "scene/carried_points.hpp"
#include "scene/fem_scene.hpp"
#include "tests/scene/long_bar.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace elastogen {
namespace {

RunDescription tet_run(fem::Element element, const std::vector<std::string>& pins,
                       const std::vector<std::string>& moves = {}) {
  RunDescription run;
  run.h = 0.05;
  run.fem = FemOptions{.element = element, .named = true};
  for (const std::string& text : pins) run.pins.push_back(parse_pin(text));
  for (const std::string& text : moves) run.moves.push_back(parse_move(text));
  return run;
}

TEST(TetPins, HoldTheBodyAtBordersThatCutTetrahedra) {
  for (const fem::Element element : {fem::Element::kTet4, fem::Element::kTet10}) {
    const RunDescription run = tet_run(element, {"x<1%", "x>99%"});
    const auto setup = set_up(long_bar(), run);
    EXPECT_TRUE(std::ranges::none_of(
        setup.warnings, [](const std::string& text) { return text.find("--pin") != text.npos; }));
    ASSERT_TRUE(setup.cut_mesh.has_value());
    const Scene& nodes = setup.cut_mesh->nodes;
    EXPECT_FALSE(nodes.dependent.empty());
    for (int64_t n = 0; n < nodes.pinned.rows(); ++n) {
      const double x = nodes.grid.rest(n, 0);
      EXPECT_EQ(nodes.holder(n) >= 0, nodes.pinned(n) != kFreeNode);
      if (nodes.holder(n) >= 0) {
        EXPECT_EQ(nodes.holder(n), x > 0.5);
      }
      // the grid fits the left border
      if (x < 0.0101) {
        EXPECT_EQ(nodes.pinned(n), kPinnedNode);
      }
      if (x > 0.0101 && x < 0.9) {
        EXPECT_EQ(nodes.pinned(n), kFreeNode);
      }
    }
    // the mass of what is free, and of what the grid's nodes hold at the left
    const fem::FemScene scene = fem_scene(setup, run);
    const Array<double> mass = fem::ElasticBody(scene.mesh, scene.materials).lumped_mass();
    double sum = 0;
    for (int64_t n = 0; n < mass.rows(); ++n) sum += mass(n);
    EXPECT_NEAR(sum, 0.99 * 0.2 * 0.2 * run.material.density, 1e-5);
  }
}

TEST(TetPins, BesideTheBodyChangeNothing) {
  for (const char* pin : {"x<-5%", "x<-0.1%"}) {
    const RunDescription run = tet_run(fem::Element::kTet4, {pin}),
                         free = tet_run(fem::Element::kTet4, {});
    const auto setup = set_up(long_bar(), run), none = set_up(long_bar(), free);
    EXPECT_FALSE(setup.cut_mesh.has_value());
    EXPECT_TRUE(std::ranges::any_of(setup.warnings, [](const std::string& text) {
      return text.find("holds nothing") != text.npos;
    }));
    const fem::FemScene a = fem_scene(setup, run), b = fem_scene(none, free);
    EXPECT_EQ(a.mesh.rest, b.mesh.rest);
    EXPECT_EQ(a.mesh.elements, b.mesh.elements);
    EXPECT_EQ(a.mesh.fill, b.mesh.fill);
    EXPECT_EQ(a.fixed, b.fixed);
  }
}

TEST(TetPins, HoldTheNodesOnAFaceOfABoxThatCutsOthers) {
  // x = 0.4 is a layer of nodes, the other faces are none
  const RunDescription run = tet_run(fem::Element::kTet4, {"box(40%,-1%,-1%,61%,55%,101%)"});
  const auto setup = set_up(long_bar(), run);
  ASSERT_TRUE(setup.cut_mesh.has_value());
  const Scene& nodes = setup.cut_mesh->nodes;
  int64_t on = 0;
  for (int64_t n = 0; n < nodes.pinned.rows(); ++n) {
    if (std::abs(nodes.grid.rest(n, 0) - 0.4) > 1e-9 || nodes.grid.rest(n, 1) > 0.11) continue;
    ++on;
    EXPECT_EQ(nodes.pinned(n), kPinnedNode);
  }
  EXPECT_GE(on, 15);
}

TEST(TetPins, MoveNodesBehindABorderByTheirHolder) {
  const RunDescription run =
      tet_run(fem::Element::kTet10, {"x<1%"}, {"x>99%: turn(0,50%,50%,1,0,0) 0:0; 1:90deg"});
  const auto setup = set_up(long_bar(), run);
  ASSERT_TRUE(setup.cut_mesh.has_value());
  const fem::FemScene scene = fem_scene(setup, run);
  ASSERT_TRUE(bool(scene.dependent_motion));
  // a body that turns with the border meets it: u_i = ubar(X_i) where u_m = ubar(X_m)
  Array<double> offset(scene.dependent.count(), 3), u(scene.mesh.rest.rows(), 3);
  scene.dependent_motion(1, offset);
  const auto turned = [&](int64_t n) -> Vec3 {
    const double y = scene.mesh.rest(n, 1) - 0.1, z = scene.mesh.rest(n, 2) - 0.1;
    return {0, -z - y, y - z};
  };
  int64_t moving = 0;
  for (int64_t i = 0; i < scene.dependent.count(); ++i) {
    if (scene.mesh.rest(scene.dependent.node(i), 0) < 0.5) continue;
    ++moving;
    Vec3 sum = {offset(i, 0), offset(i, 1), offset(i, 2)};
    for (int64_t k = 0; k < scene.dependent.parents(i).rows; ++k)
      sum = plus(sum, scaled(turned(scene.dependent.parents(i)(k)), scene.dependent.weights(i)(k)));
    EXPECT_LT(norm(minus(sum, turned(scene.dependent.node(i)))), 1e-14);
  }
  EXPECT_GT(moving, 0);
  // points of the asset behind the border go with it
  const CarriedPoints points = carried_points(setup);
  EXPECT_EQ(points.moved.size(), 4u);
}

}  // namespace
}  // namespace elastogen
