// SPDX-License-Identifier: Apache-2.0
#include "core/holder.hpp"

#include "core/vec3.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace elastogen {
namespace {

constexpr double kPi = std::numbers::pi;

/// A quarter turn about an axis along z in a second, then on to three quarters in another.
Holder turning() {
  Holder holder;
  holder.turns = true;
  holder.centre = {1, 2, 3};
  holder.path = {{0, {}}, {1, {0, 0, kPi / 2}}, {2, {0, 0, 1.5 * kPi}}};
  return holder;
}

TEST(Holder, AtRestMovesNothing) {
  EXPECT_FALSE(Holder{}.moves());
  EXPECT_EQ(held_displacement(Holder{}, {1, 2, 3}, 4), (Vec3{}));
  EXPECT_EQ(held_velocity(Holder{}, {1, 2, 3}, 4), (Vec3{}));
}

TEST(Holder, ShiftsAllPointsAlike) {
  Holder holder;
  holder.path = {{0, {}}, {2, {4, 0, -2}}};
  EXPECT_EQ(held_displacement(holder, {5, 6, 7}, 1), (Vec3{2, 0, -1}));
  EXPECT_EQ(held_velocity(holder, {5, 6, 7}, 1), (Vec3{2, 0, -1}));
}

TEST(Holder, TurnsRightHandedAboutItsAxis) {
  const Holder holder = turning();
  // a point two along x of the axis is carried to two along y, then to two against y
  const Vec3 u = held_displacement(holder, {3, 2, 9}, 1),
             w = held_displacement(holder, {3, 2, 9}, 2);
  for (const auto& [of, wanted] : {std::pair(u, Vec3{-2, 2, 0}), {w, Vec3{-2, -2, 0}}})
    for (size_t d = 0; d < 3; ++d) EXPECT_NEAR(of[d], wanted[d], 1e-14);
  const auto R = held_rotation(holder, 1);
  const double wanted[9] = {0, -1, 0, 1, 0, 0, 0, 0, 1};
  for (size_t k = 0; k < 9; ++k) EXPECT_NEAR(R[k], wanted[k], 1e-15);
}

TEST(Holder, VelocityIsTheRateOfThePlace) {
  const Holder holder = turning();
  const Vec3 X = {2, -1, 5};
  constexpr double kStep = 1e-6;
  for (const double time : {0.3, 1.0, 1.7}) {
    const Vec3 now = held_displacement(holder, X, time);
    const Vec3 rate = scaled(minus(now, held_displacement(holder, X, time - kStep)), 1 / kStep);
    const Vec3 v = held_velocity(holder, plus(X, now), time);
    for (size_t d = 0; d < 3; ++d) EXPECT_NEAR(v[d], rate[d], 1e-4) << time;
  }
}

}  // namespace
}  // namespace elastogen
