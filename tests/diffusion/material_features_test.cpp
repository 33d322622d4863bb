// SPDX-License-Identifier: Apache-2.0
#include "diffusion/material_features.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace elastogen {
namespace {

using Features = std::vector<double>;

TEST(MaterialFeatures, AreWeightsOfLawsAndPoissonsRatio) {
  const double s = std::sqrt(0.2 / 1.4);
  EXPECT_EQ(material_features(fit_material("neo-hookean", 0.4)),
            (Features{0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, std::sqrt((1 - 0.8) / 1.4), 1 / 0.6, 0}));
  const Features mixed = material_features(fit_material("0.25*stvk+0.75*hencky", 0.4));
  EXPECT_EQ(mixed[3], 0.25);
  EXPECT_EQ(mixed[4], 0.75);
  EXPECT_NEAR(mixed[14], 0.25 * s, 1e-15);
}

TEST(MaterialFeatures, HoldTheShapesOfFamilies) {
  const Features ogden = material_features(fit_material("ogden=-2", 0));
  EXPECT_EQ(ogden, (Features{0, 0, 0, 0, 0, 1, 0, 0, -0.5, 0.25, 0, 0, 1, 1, 0}));
  const Features all =
      material_features(fit_material("0.5*ogden=8+0.25*mooney-rivlin=0.2+0.25*gent=20", 0));
  EXPECT_EQ(all, (Features{0, 0, 0, 0, 0, 0.5, 0.25, 0.25, 1, 2, 0.05, 0.125, 1, 1, 0}));
}

TEST(MaterialFeatures, AddTheTermsOfOneLaw) {
  const Features x = material_features(fit_material("0.5*ogden=4+0.5*ogden=-4", 0.3));
  EXPECT_EQ(x[5], 1);
  EXPECT_EQ(x[8], 0);
  EXPECT_EQ(x[9], 1);
}

TEST(MaterialFeatures, HaveTheDistanceOfEuclid) {
  const Features x = material_features(fit_material("ogden=4", 0)),
                 y = material_features(fit_material("ogden=0", 0));
  EXPECT_EQ(feature_distance(x.data(), y.data()), 2);
  EXPECT_EQ(feature_distance(x.data(), x.data()), 0);
}

}  // namespace
}  // namespace elastogen
