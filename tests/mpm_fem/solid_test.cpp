// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/materials/solid.hpp"

#include "tests/mpm_fem/return_maps.hpp"

#include <gtest/gtest.h>

namespace elastogen {
namespace {

template <int d, class L>
bool has_law(const Solid& solid) {
  return std::holds_alternative<L>(point_law<d>(solid));
}

TEST(Solid, HasTheLawOfItsYield) {
  Solid solid{.elastic = test::plastic_solid()};
  EXPECT_FALSE(solid.is_plastic());
  EXPECT_TRUE((has_law<3, ElasticLaw<double>>(solid)));
  solid.yield = test::kSand;
  EXPECT_TRUE(solid.is_plastic());
  EXPECT_TRUE((has_law<2, DruckerPrager<double, 2>>(solid)));
  solid.yield = test::kSnow;
  EXPECT_TRUE((has_law<3, CamClay<double, 3>>(solid)));
  solid.yield = test::kMetal;
  solid.elastic.law = Law::kHencky;
  EXPECT_TRUE((has_law<3, VonMises<double, 3>>(solid)));
  solid.elastic.law = Law::kNeoHookean;
  EXPECT_TRUE((has_law<3, AssociativeNeoVonMises<double>>(solid)));
  EXPECT_TRUE((has_law<2, NeoVonMises<double, 2>>(solid)));
}

TEST(Solid, KnowsWhichLawsHaveAnEnergy) {
  EXPECT_TRUE((has_energy<ElasticLaw<double>>));
  EXPECT_TRUE((has_energy<VonMises<double, 3>>));
  EXPECT_TRUE((has_energy<AssociativeNeoVonMises<double>>));
  EXPECT_TRUE((has_energy<NeoVonMises<double, 2>>));
  EXPECT_FALSE((has_energy<NeoVonMises<double, 3>>));
  EXPECT_FALSE((has_energy<DruckerPrager<double, 2>>));
  EXPECT_FALSE((has_energy<CamClay<double, 3>>));
}

TEST(Solid, KeepsTheHistoryOfEachLawAsOneNumber) {
  Solid solid{.elastic = test::plastic_solid()};
  for (const auto& yield : {Yield(test::kMetal), Yield(test::kSand), Yield(test::kSnow)}) {
    solid.yield = yield;
    std::visit([](const auto& law) { EXPECT_EQ(memory_of(history_of(law, 0.25)), 0.25); },
               point_law<3>(solid));
  }
}

}  // namespace
}  // namespace elastogen
