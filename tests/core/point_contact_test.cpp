// SPDX-License-Identifier: Apache-2.0
#include "core/point_contact.hpp"

#include "core/scene.hpp"

#include <gtest/gtest.h>

namespace elastogen {
namespace {

/// Two points, `apart` from each other along y, in voxels of 0.4 m.
Scene scene_of(double apart) {
  Scene scene;
  scene.grid.h = 0.4;
  scene.dt = 0.01;
  scene.surface.position = Array<double>(2, 3);
  scene.surface.position(1, 1) = apart;
  return scene;
}

TEST(PointContact, LayerIsAQuarterOfAVoxel) {
  EXPECT_EQ(contact_layer(scene_of(2)), 0.1);
}

TEST(PointContact, SlipRangeIsAThousandthOfTheFreeFallSpeed) {
  // sqrt(9.81 * 4) = 6.264 m/s
  EXPECT_NEAR(slip_range(scene_of(4)), 6.26418390534633e-5, 1e-18);
  // of the length of a voxel where the body is shorter
  EXPECT_NEAR(slip_range(scene_of(0)), 1.98090888230625e-5, 1e-18);
  EXPECT_EQ(contact_lengths(scene_of(4)).layer, 0.1);
  EXPECT_EQ(contact_lengths(scene_of(4)).slip_range, slip_range(scene_of(4)));
}

TEST(PointContact, StiffnessIsThatOfAVoxel) {
  // kappa = E D^2/h with D = h/4, so that kappa b''/D^2 times the face's h^2 is E h times b''
  EXPECT_EQ(contact_stiffness(3200, 0.25, 1), 200);
}

// at a quarter of the layer an area has the kinetic energy of the voxel behind it
TEST(PointContact, TheLayerStopsTheOutermostVoxelsAtTheSpeedOfAnImpact) {
  const double h = 0.1, layer = h / 4, area = 1e-4, v = 3;
  const Material soft{.young = 1e3, .density = 1100}, stiff{.young = 1e7, .density = 1100};
  const double held = contact_stiffness(contact_young(soft, v), layer, h);
  const double kinetic = soft.density * area * h * v * v / 2;
  EXPECT_NEAR(area * held * barrier(0.2387).value / kinetic, 1, 0.2);
  EXPECT_EQ(contact_young(stiff, v), stiff.young);
  EXPECT_EQ(contact_young(soft, 0), soft.young);
}

}  // namespace
}  // namespace elastogen
