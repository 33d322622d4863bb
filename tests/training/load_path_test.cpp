// SPDX-License-Identifier: Apache-2.0
#include "training/load_path.hpp"

#include "core/error.hpp"
#include "tests/support/laws.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace elastogen {
namespace {

constexpr LoadPath kLoadPaths[] = {LoadPath::kUniaxial, LoadPath::kBiaxial, LoadPath::kShear,
                                   LoadPath::kVolume};

TargetLaw law_of(const Law& law, double poisson) {
  return target_law({"", {{law, 1}}, poisson});
}

TEST(LoadPath, IsThatOfTheLinearTheoryInTheLogarithmsOfHencky) {
  // with Hencky's law stress and strain of the linear theory are Kirchhoff's and ln s
  for (const double nu : {0.0, 0.3, 0.48, 0.499}) {
    const TargetLaw law = law_of(Law::kHencky, nu);
    for (const double l : {0.5, 0.9, 1 + 1e-7, 1.3, 3.0}) {
      const double e = std::log(l);
      struct {
        LoadPath path;
        double side, kirchhoff;
      } const kExact[] = {{LoadPath::kUniaxial, -nu * e, e},
                          {LoadPath::kBiaxial, -2 * nu / (1 - nu) * e, e / (1 - nu)},
                          {LoadPath::kShear, -nu / (1 - nu) * e, e / (1 - nu * nu)},
                          {LoadPath::kVolume, e, e / (1 - 2 * nu)}};
      for (const auto& exact : kExact) {
        const auto state = balanced_state(law, exact.path, l);
        ASSERT_TRUE(state);
        EXPECT_NEAR(state->e[2], exact.side, 4e-16 + 1e-13 * std::abs(e)) << path_name(exact.path);
        // the bulk modulus multiplies the rounding of s
        EXPECT_NEAR(state->stress, exact.kirchhoff / l, 1e-15 / (1 - 2 * nu) * (1 + std::abs(e)))
            << path_name(exact.path) << " nu " << nu << " l " << l;
      }
    }
  }
}

TEST(LoadPath, KeepsTheClosedFormOfTheNeoHookeanSide) {
  // mu (b^2 - 1) + lambda ln J = 0 gives the stretch of a side b
  const double nu = 0.45;
  const TargetLaw law = law_of(Law::kNeoHookean, nu);
  const double mu = law.law[0].mu, lambda = law.law[0].lambda;
  for (const double b : {0.6, 0.8, 0.99, 1.2, 1.4}) {
    const double log_J = -mu / lambda * (b * b - 1), J = std::exp(log_J);
    const auto stress = [&](double l) { return mu * (l - 1 / l) + lambda * log_J / l; };
    struct {
      LoadPath path;
      double stretch;
    } const kExact[] = {{LoadPath::kUniaxial, J / (b * b)},
                        {LoadPath::kBiaxial, std::sqrt(J / b)},
                        {LoadPath::kShear, J / b}};
    for (const auto& exact : kExact) {
      const auto state = balanced_state(law, exact.path, exact.stretch);
      ASSERT_TRUE(state);
      EXPECT_NEAR(state->e[2], std::log(b), 1e-13) << path_name(exact.path);
      EXPECT_NEAR(state->stress, stress(exact.stretch), 1e-12) << path_name(exact.path);
    }
  }
}

TEST(LoadPath, TakesAllWorkByTheStretchedAxes) {
  // free sides do no work: dpsi/dl is the stress times the number of axes that are stretched by l
  constexpr double kAxes[] = {1, 2, 1, 3}, kStep = 1e-5;
  for (const Law& law : test::kLaws)
    for (const LoadPath path : kLoadPaths)
      for (const double l : {0.7, 0.95, 1.2, 1.4}) {
        const TargetLaw target = law_of(law, 0.3);
        const auto at = [&](double stretch) { return balanced_state(target, path, stretch); };
        const auto state = at(l), before = at(l - kStep), after = at(l + kStep);
        ASSERT_TRUE(state && before && after)
            << law_name(law) << ' ' << path_name(path) << ' ' << l;
        const double work = (after->energy - before->energy) / (2 * kStep);
        EXPECT_NEAR(work, kAxes[size_t(path)] * state->stress, 1e-8 + 1e-6 * std::abs(work))
            << law_name(law) << ' ' << path_name(path) << ' ' << l;
      }
}

TEST(LoadPath, EndsWhereTheSidesOfStVenantKirchhoffVanish) {
  // b^2 = 1 - nu (l^2 - 1)
  const double nu = 0.4, end = std::sqrt(1 + 1 / nu);
  const TargetLaw law = law_of(Law::kStvk, nu);
  const double l = 0.99 * end, green = (l * l - 1) / 2;
  const auto state = balanced_state(law, LoadPath::kUniaxial, l);
  ASSERT_TRUE(state);
  EXPECT_NEAR(std::exp(2 * state->e[1]), 1 - 2 * nu * green, 1e-12);
  EXPECT_NEAR(state->stress, l * green, 1e-12);
  EXPECT_FALSE(balanced_state(law, LoadPath::kUniaxial, 1.01 * end));
}

TEST(LoadPath, IsZeroAtRest) {
  for (const LoadPath path : kLoadPaths) {
    const auto state = balanced_state(law_of(Law::gent(20), 0.3), path, 1);
    ASSERT_TRUE(state);
    EXPECT_EQ(state->e, (Vec3{0, 0, 0}));
    EXPECT_EQ(state->stress, 0);
    EXPECT_EQ(state->energy, 0);
  }
}

TEST(LoadPath, RejectsStretchesThatAreNone) {
  const double inf = std::numeric_limits<double>::infinity();
  for (const double stretch : {0.0, -1.0, inf, std::nan("")})
    EXPECT_THROW(balanced_state(law_of(Law::kHencky, 0.3), LoadPath::kShear, stretch), Error);
}

}  // namespace
}  // namespace elastogen
