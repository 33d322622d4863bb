// SPDX-License-Identifier: Apache-2.0
#include "core/quaternion.hpp"

#include "tests/support/matrices.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace elastogen {
namespace {

using test::distance, test::Random, test::rotation, test::rotation_of;

TEST(Quaternion, IsThatOfTheRotationWhicheverComponentLeads) {
  // half turns about the axes and close to them: each component is the largest once
  for (const double near : {0.0, 1e-9, 1e-3, 0.3}) {
    const double q[4][4] = {{1, near, -near, near},
                            {near, 1, near, -near},
                            {-near, near, 1, near},
                            {near, -near, near, 1}};
    for (const auto& c : q) {
      const double length = std::sqrt(1 + 3 * near * near);
      const Quaternion<double> found = quaternion_of(rotation_of(c[0], c[1], c[2], c[3]));
      EXPECT_NEAR(found.w, c[0] / length, 4e-16);
      EXPECT_NEAR(found.x, c[1] / length, 4e-16);
      EXPECT_NEAR(found.y, c[2] / length, 4e-16);
      EXPECT_NEAR(found.z, c[3] / length, 4e-16);
    }
  }
}

TEST(Quaternion, GivesTheRotationBack) {
  Random random(1);
  for (int k = 0; k < 1000; ++k) {
    const Mat3<double> R = rotation(random);
    EXPECT_LT(distance(rotation_matrix(quaternion_of(R)), R), 4e-15);
    EXPECT_LT(distance(rotation_or_zero(quaternion_of(R)), R), 4e-15);
    Mat3<float> single;
    for (int m = 0; m < 9; ++m) single.m[m] = float(R.m[m]);
    const Mat3<float> back = rotation_matrix(quaternion_of(single));
    for (int m = 0; m < 9; ++m) EXPECT_NEAR(back.m[m], R.m[m], 8e-7);
  }
}

TEST(Quaternion, ZeroStandsForNoRotation) {
  for (const double value : rotation_or_zero(Quaternion<double>{}).m) EXPECT_EQ(value, 0);
}

}  // namespace
}  // namespace elastogen
