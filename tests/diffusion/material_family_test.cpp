// SPDX-License-Identifier: Apache-2.0
#include "diffusion/material_family.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

namespace elastogen {
namespace {

constexpr int kMany = 8000;

/// Whether a count of kMany is a share of it within five standard deviations.
bool is_share(int count, double share) {
  return std::abs(count - share * kMany) < 5 * std::sqrt(share * (1 - share) * kMany);
}

TEST(MaterialFamily, HasTheSharesOfItsGroups) {
  std::map<MaterialGroup, int> groups;
  int single = 0, two = 0, three = 0;
  for (uint64_t n = 0; n < kMany; ++n) {
    const FitMaterial material = family_material(5, n);
    ++groups[group_of(material)];
    if (group_of(material) != MaterialGroup::kFiveLaws) continue;
    single += material.terms.size() == 1;
    two += material.terms.size() == 2;
    three += material.terms.size() == 3;
  }
  EXPECT_TRUE(is_share(single, 0.30)) << single;
  EXPECT_TRUE(is_share(two, 0.20)) << two;
  EXPECT_TRUE(is_share(three, 0.20)) << three;
  EXPECT_TRUE(is_share(groups[MaterialGroup::kOgden], 0.15));
  EXPECT_TRUE(is_share(groups[MaterialGroup::kMooneyRivlin], 0.07));
  EXPECT_TRUE(is_share(groups[MaterialGroup::kGent], 0.08));
}

TEST(MaterialFamily, SpreadsPoissonsRatioTowardsIncompressibility) {
  // below nu: half of them 2 nu/0.99, half of them ln(1/(1 - 2 nu))/ln(100)
  for (const double nu : {0.1, 0.25, 0.4, 0.48}) {
    int below = 0;
    for (uint64_t n = 0; n < kMany; ++n) below += family_material(5, n).poisson < nu;
    const double share = 0.5 * nu / 0.495 + 0.5 * std::log(1 / (1 - 2 * nu)) / std::log(100.0);
    EXPECT_TRUE(is_share(below, share)) << nu << ": " << below << " of " << kMany;
  }
}

TEST(MaterialFamily, StaysWithinItsRanges) {
  std::set<Law::Kind> kinds;
  for (uint64_t n = 0; n < kMany; ++n) {
    const FitMaterial material = family_material(9, n);
    EXPECT_TRUE(material.poisson >= 0 && material.poisson <= 0.495) << material.name;
    // weights above 0, each law once, shapes within their ranges
    double sum = 0;
    std::set<Law::Kind> here;
    for (const LawTerm& term : material.terms) {
      const double shape = term.law.shape;
      EXPECT_GT(term.weight, 0) << material.name;
      EXPECT_TRUE(here.insert(term.law.kind).second) << material.name;
      if (term.law.kind == Law::Kind::kOgden) {
        EXPECT_TRUE(shape >= -4 && shape <= 8) << shape;
      }
      if (term.law.kind == Law::Kind::kMooneyRivlin) {
        EXPECT_TRUE(shape >= 0 && shape <= 1) << shape;
      }
      if (term.law.kind == Law::Kind::kGent) {
        EXPECT_TRUE(shape >= 12 && shape <= 200) << shape;
      }
      sum += term.weight;
    }
    EXPECT_NEAR(sum, 1, 1e-9);
    kinds.insert(here.begin(), here.end());
  }
  // all laws occur
  EXPECT_EQ(kinds.size(), 8u);
}

TEST(MaterialFamily, IsAFunctionOfSeedAndNumber) {
  EXPECT_EQ(family_material(1, 77).name, family_material(1, 77).name);
  int same = 0;
  for (uint64_t n = 0; n < 200; ++n) {
    same += family_material(1, n).name == family_material(2, n).name;
    same += family_material(1, n).name == family_material(1, n + 1).name;
  }
  EXPECT_EQ(same, 0);
}

}  // namespace
}  // namespace elastogen
