// SPDX-License-Identifier: Apache-2.0
#include "core/material.hpp"

#include "core/error.hpp"
#include "tests/support/laws.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <set>

namespace elastogen {
namespace {

TEST(Material, LawNamesGoThereAndBack) {
  std::set<std::string> names;
  for (const Law& law : test::kLaws) {
    EXPECT_EQ(law_from_name(law_name(law)), law);
    names.insert(law_name(law));
  }
  EXPECT_EQ(names, (std::set<std::string>{"fixed-corotated", "neo-hookean", "stable-neo-hookean",
                                          "stvk", "hencky", "ogden=5.5", "ogden=-3",
                                          "mooney-rivlin=0.25", "gent=12"}));
}

TEST(Material, ShapeParametersAreReadToTheLastDigitAndKeptInRange) {
  for (const double shape : {0.1 + 0.2, -1e-7, 7.0})
    EXPECT_EQ(law_from_name(law_name(Law::ogden(shape))).shape, shape);
  for (const char* bad : {"ogden", "ogden=", "ogden=4x", "ogden=nan", "ogden=21", "gent=0",
                          "mooney-rivlin=1.1", "stvk=1", "ogden=4=4"}) {
    try {
      law_from_name(bad);
      ADD_FAILURE() << bad;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(concat("'", bad, "'")), std::string::npos);
      EXPECT_NE(std::string(error.what()).find("=NUMBER"), std::string::npos);
    }
  }
}

TEST(Material, UnknownNamesAreRejectedWithTheKnownOnes) {
  try {
    law_from_name("arruda");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kUsage);
    EXPECT_NE(std::string(error.what()).find("'arruda'"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("stable-neo-hookean"), std::string::npos);
  }
  try {
    material_preset("unobtainium");
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("'unobtainium'"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("rubber"), std::string::npos);
  }
}

TEST(Material, LameConstantsGiveBackYoungAndPoisson) {
  for (const double poisson : {0.0, 0.3, 0.499}) {
    Material m;
    m.young = 3e5, m.poisson = poisson;
    const double mu = m.mu(), lambda = m.lambda();
    EXPECT_NEAR(mu * (3 * lambda + 2 * mu) / (lambda + mu), 3e5, 1e-6);
    EXPECT_NEAR(lambda / (2 * (lambda + mu)), poisson, 1e-12);
  }
}

TEST(Material, PresetsAreValidDistinctAndHaveASource) {
  std::set<std::string> names;
  for (const MaterialPreset& preset : material_presets()) {
    EXPECT_NO_THROW(check_material(preset.material));
    EXPECT_TRUE(names.insert(preset.material.name).second) << preset.material.name;
    EXPECT_EQ(&material_preset(preset.material.name), &preset);
    const std::string kind = preset.kind;
    EXPECT_TRUE(kind == "measured" || kind == "literature" || kind == "look") << kind;
    EXPECT_GT(std::string_view(preset.source).size(), 10u);
  }
  EXPECT_FALSE(names.empty());
}

TEST(Material, NumbersOutsideTheirRangeAreRejected) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto with = [](double young, double poisson, double density) {
    return Material{"m", Law::kStvk, young, poisson, density};
  };
  EXPECT_NO_THROW(check_material(with(1, 0, 1)));
  EXPECT_NO_THROW(check_material(with(1e12, 0.4999, 1)));
  for (const double bad : {0.0, -1.0, kNan, kInfinity}) {
    EXPECT_THROW(check_material(with(bad, 0.3, 1)), Error);
    EXPECT_THROW(check_material(with(1, 0.3, bad)), Error);
  }
  for (const double bad : {-1e-9, 0.5, 1.0, kNan})
    EXPECT_THROW(check_material(with(1, bad, 1)), Error);
  for (const Law& bad : {Law::ogden(kNan), Law::ogden(-21), Law::gent(0), Law::gent(kInfinity),
                         Law::mooney_rivlin(-0.1)})
    EXPECT_THROW(check_material({"m", bad, 1, 0.3, 1}), Error);
}

}  // namespace
}  // namespace elastogen
