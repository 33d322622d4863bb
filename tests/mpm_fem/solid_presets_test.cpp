// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/materials/solid_presets.hpp"

#include "core/error.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace elastogen {
namespace {

TEST(SolidPresets, AllHaveALawAndASource) {
  for (const MaterialPreset& named : yielding_presets()) {
    const SolidPreset preset = solid_preset(named.material.name);
    EXPECT_TRUE(preset.solid.is_plastic()) << named.material.name;
    EXPECT_NO_THROW(point_law<3>(preset.solid)) << named.material.name;
    EXPECT_GT(std::string(preset.source).size(), 20u);
  }
  for (const MaterialPreset& named : material_presets())
    EXPECT_FALSE(solid_preset(named.material.name).solid.is_plastic());
}

TEST(SolidPresets, AWrongNameListsThemAll) {
  try {
    solid_preset("unobtainium");
    FAIL();
  } catch (const Error& error) {
    for (const char* name : {"rubber", "plush", "sand", "steel"})
      EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << name;
  }
}

TEST(SolidPresets, GrainsAreWhatHardlyHoldsTogether) {
  for (const char* name : {"sand", "wet-sand", "snow"})
    EXPECT_TRUE(is_granular(solid_preset(name).solid.yield)) << name;
  for (const char* name : {"packed-snow", "clay", "steel", "rubber"})
    EXPECT_FALSE(is_granular(solid_preset(name).solid.yield)) << name;
}

TEST(SolidPresets, SlopeAndAngleOfTheCriticalStateAreInverse) {
  // sin = 1/2: 3/(5/2)
  EXPECT_NEAR(critical_slope(std::numbers::pi / 6), 1.2, 1e-15);
  for (const double angle : {0.0, 0.3, 1.0})
    EXPECT_NEAR(critical_angle(critical_slope(angle)), angle, 1e-14);
}

}  // namespace
}  // namespace elastogen
