// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/fem/element_mesh.hpp"

#include "core/error.hpp"
#include "tests/mpm_fem/bodies.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

namespace elastogen {
namespace {

using test::Element;
using test::ElementMesh;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// The message of the error that a call throws; empty: none.
std::string message_from(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

ElementMesh voxels(Element element = Element::kVoxel) {
  return fem::voxel_mesh(test::voxel_scene(make_box(2, 1, 1, 0.1), test::solid()), element);
}

TEST(ElementMesh, NamesAreThoseOfTheElementsAndAnUnknownOneListsThem) {
  for (const Element element : test::kAllElements)
    EXPECT_EQ(fem::element_from_name(fem::element_name(element)), element);
  EXPECT_EQ(
      message_from([] { fem::element_from_name("brick"); }),
      "unknown element 'brick'; known are voxel, hex, hex-bbar, tet4, tet10, tet10-bbar, tri3");
}

TEST(ElementMesh, VoxelsAreHexahedraOnTheNodesOfTheirGrid) {
  const Scene scene = test::voxel_scene(make_box(3, 2, 4, 0.1, {5, -7, 2}), test::solid());
  for (const Element element : {Element::kVoxel, Element::kHex, Element::kHexBbar}) {
    const ElementMesh mesh = fem::voxel_mesh(scene, element);
    fem::check_mesh(mesh);
    EXPECT_EQ(mesh.rest, scene.grid.rest);
    EXPECT_EQ(mesh.elements, scene.grid.corners);
  }
  EXPECT_NE(message_from([&] { fem::voxel_mesh(scene, Element::kTet4); }), "");
  EXPECT_NE(message_from([&] { fem::voxel_mesh(Scene{}, Element::kHex); }), "");
}

TEST(ElementMesh, WhatIsWrongIsNamedWithItsPlace) {
  const struct {
    ElementMesh mesh;
    std::function<void(ElementMesh&)> spoil;
    const char* named;
  } cases[] = {
      {voxels(), [](ElementMesh& m) { m.elements(1, 3) = 99; }, "elements(1, 3)"},
      {voxels(), [](ElementMesh& m) { m.elements(1, 3) = -1; }, "elements(1, 3)"},
      {voxels(), [](ElementMesh& m) { m.elements = Array<int32_t>(); }, "no elements"},
      {voxels(), [](ElementMesh& m) { m.rest(4, 2) = kNaN; }, "rest(4, 2)"},
      {voxels(), [](ElementMesh& m) { m.rest(0, 0) += 0.01; }, "element 0 must be a cube"},
      {voxels(), [](ElementMesh& m) { m.h = 0; }, "h must be positive"},
      {voxels(), [](ElementMesh& m) { m.fill(1) = 0; }, "fill(1, 0)"},
      {voxels(), [](ElementMesh& m) { m.fill = Array<double>(); }, "needs their fill"},
      {voxels(), [](ElementMesh& m) { m.fill = Array<double>(5); }, "fill must be"},
      {voxels(), [](ElementMesh& m) { m.shape_mean(1, 7) = kNaN; }, "shape_mean(1, 7)"},
      {voxels(), [](ElementMesh& m) { m.variance(0, 2) = -1; }, "variance(0, 2)"},
      {voxels(), [](ElementMesh& m) { m.material = Array<int32_t>(1); }, "material must be"},
      {voxels(Element::kHex), [](ElementMesh& m) { m.element = Element::kTet4; }, "(elements, 4)"},
      {test::block(Element::kTet4, 1, 1, 1, 1),
       [](ElementMesh& m) { std::swap(m.elements(2, 0), m.elements(2, 1)); },
       "element 2 must have a positive Jacobian"},
      {test::block(Element::kHex, 2, 1, 1, 1), [](ElementMesh& m) { m.rest(2, 0) = -2; },
       "element 1 must have a positive Jacobian"},
      {test::block(Element::kTet10, 1, 1, 1, 1),
       [](ElementMesh& m) {
         for (int d = 0; d < 3; ++d) m.rest(m.elements(3, 4), d) = m.rest(m.elements(3, 3), d);
       },
       "must have a positive Jacobian"},
  };
  // each mesh is sound until it is spoilt
  for (const auto& [mesh, spoil, named] : cases) {
    EXPECT_EQ(message_from([&] { fem::check_mesh(mesh); }), "");
    ElementMesh bad = mesh;
    spoil(bad);
    const std::string message = message_from([&] { fem::check_mesh(bad); });
    EXPECT_NE(message.find(named), std::string::npos) << named << ": '" << message << "'";
  }
}

TEST(ElementMesh, BodyWithoutTheMaterialOfAnElementIsRefused) {
  ElementMesh mesh = test::block(Element::kHex, 2, 1, 1, 1);
  mesh.material(1) = 1;
  EXPECT_EQ(message_from([&] { fem::ElasticBody(mesh, {test::solid()}); }),
            "element 1 has material 1 of 1");
  Material bad = test::solid();
  bad.poisson = 0.5;
  EXPECT_NE(message_from([&] { fem::ElasticBody(mesh, {test::solid(), bad}); }), "");
  const fem::ElasticBody body(mesh, {test::solid(), test::solid()});
  EXPECT_NE(message_from([&] { body.energy(Array<double>(3, 3)); }), "");
}

}  // namespace
}  // namespace elastogen
