// SPDX-License-Identifier: Apache-2.0
#include "core/path.hpp"

#include "core/error.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace elastogen {
namespace {

Path there_and_back() {
  return {{1, {0, 0, 0}}, {3, {4, -2, 0}}, {4, {0, 0, 0}}};
}

/// (f(t) - f(t - dt)) / dt of the first component.
double slope_before(const Path& path, double time) {
  constexpr double kStep = 1e-7;
  return (offset_at(path, time)[0] - offset_at(path, time - kStep)[0]) / kStep;
}

TEST(Path, IsStraightBetweenKeysAndAtRestOutside) {
  const Path path = there_and_back();
  EXPECT_EQ(offset_at(path, -1), (Vec3{0, 0, 0}));
  EXPECT_EQ(offset_at(path, 2), (Vec3{2, -1, 0}));
  EXPECT_EQ(offset_at(path, 3), (Vec3{4, -2, 0}));
  EXPECT_EQ(offset_at(path, 3.5), (Vec3{2, -1, 0}));
  EXPECT_EQ(offset_at(path, 9), (Vec3{0, 0, 0}));
  EXPECT_EQ(offset_at(Path{}, 3), (Vec3{0, 0, 0}));
}

TEST(Path, ThatEasesRestsAtItsKeysAndIsHalfWayBetweenThem) {
  Path path = there_and_back();
  path.eases = true;
  for (const double key : {1.0, 3.0, 4.0}) {
    EXPECT_EQ(rate_at(path, key), (Vec3{0, 0, 0}));
    EXPECT_NEAR(slope_before(path, key), 0, 1e-5);
  }
  EXPECT_DOUBLE_EQ(offset_at(path, 2)[0], 2);
  EXPECT_DOUBLE_EQ(offset_at(path, 1.5)[0], 4 * (3 * 0.0625 - 2 * 0.015625));
}

TEST(Path, RateIsTheSlopeJustBefore) {
  for (const bool eases : {false, true})
    for (const bool loops : {false, true}) {
      Path path = there_and_back();
      path.eases = eases, path.loops = loops;
      for (const double time : {0.5, 1.4, 2.9, 3.0, 3.3, 4.0, 5.2, 8.9})
        EXPECT_NEAR(rate_at(path, time)[0], slope_before(path, time), 1e-5) << time;
    }
}

TEST(Path, ThatLoopsBeginsAnewAfterItsLastKey) {
  Path path = there_and_back();
  path.loops = true;
  for (const double time : {1.0, 1.3, 2.5, 3.0, 3.9, 4.0})
    for (const int rounds : {1, 2, 7})
      for (size_t d = 0; d < 3; ++d)
        EXPECT_NEAR(offset_at(path, time + 3 * rounds)[d], offset_at(path, time)[d], 1e-12);
  EXPECT_EQ(offset_at(path, 0.5), (Vec3{0, 0, 0}));
}

TEST(Path, TellsTheNextKey) {
  Path path = there_and_back();
  EXPECT_EQ(next_key(path, 0), 1);
  EXPECT_EQ(next_key(path, 1), 3);
  EXPECT_EQ(next_key(path, 3.5), 4);
  EXPECT_TRUE(std::isinf(next_key(path, 4)));
  path.loops = true;
  EXPECT_EQ(next_key(path, 0), 1);
  EXPECT_EQ(next_key(path, 4), 6);
  EXPECT_EQ(next_key(path, 6.5), 7);
  EXPECT_TRUE(std::isinf(next_key(Path{}, 0)));
}

TEST(Path, MustAscendAndBeFinite) {
  EXPECT_NO_THROW(check_path(there_and_back()));
  EXPECT_THROW(check_path({{1, {}}, {1, {}}}), Error);
  EXPECT_THROW(check_path({{0, {NAN, 0, 0}}}), Error);
  Path path = {{0, {}}};
  path.loops = true;
  EXPECT_THROW(check_path(path), Error);
}

}  // namespace
}  // namespace elastogen
