// SPDX-License-Identifier: Apache-2.0
// The table against its source, here a closed form: the difference of two laws with the same
// moduli, as a net that stands for another law would add it.

#include "network/law/mtl_table.hpp"

#include "tests/network/law/mtl_support.hpp"

#include <gtest/gtest.h>

#include <array>

namespace elastogen::test {
namespace {

constexpr double kPoisson = 0.3;

/// Fixed corotated less neo-Hookean, faded out from 0.6 to 1.
double difference(const double e[3]) {
  double fade = 1;
  for (int i = 0; i < 3; ++i) {
    const double x = std::clamp((std::abs(e[i]) - 0.6) / 0.4, 0.0, 1.0);
    fade *= 1 - x * x * x * (10 + x * (6 * x - 15));
  }
  return fade * (in_logs(Law::kFixedCorotated, kPoisson, e).psi -
                 in_logs(Law::kNeoHookean, kPoisson, e).psi);
}

MtlTable table(int cells) {
  const auto source = [](const double* e, int64_t n, double* value) {
    for (int64_t k = 0; k < n; ++k) value[k] = difference(e + 3 * k);
  };
  return {source, cells};
}

/// Largest error of value, slope and curvature, five coarse knots away from where it fades.
std::array<double, 3> table_errors(const MtlTable& table) {
  const std::vector<double> e = strains(4000, 1000, 0.3, 2);
  std::array<double, 3> worst = {};
  for (size_t k = 0; k < 4000; ++k) {
    const double* place = e.data() + 3 * k;
    const LogResponse<double> r = table.evaluate<true>(place);
    const LogJet a = in_logs(Law::kFixedCorotated, kPoisson, place),
                 b = in_logs(Law::kNeoHookean, kPoisson, place);
    worst[0] = std::max(worst[0], std::abs(r.psi - (a.psi - b.psi)));
    for (int i = 0; i < 3; ++i) worst[1] = std::max(worst[1], std::abs(r.w[i] - (a.w[i] - b.w[i])));
    for (int c = 0; c < 6; ++c)
      worst[2] = std::max(worst[2], std::abs(r.ww[c] - (a.ww[c] - b.ww[c])));
  }
  return worst;
}

TEST(MtlTable, ConvergesWithTheOrdersOfCubicSplines) {
  const auto coarse = table_errors(table(16)), fine = table_errors(table(32));
  EXPECT_LT(fine[0], 4e-6);
  EXPECT_LT(fine[1], 6e-5);
  EXPECT_LT(fine[2], 4e-3);
  EXPECT_GT(std::log2(coarse[0] / fine[0]), 3.5);
  EXPECT_GT(std::log2(coarse[1] / fine[1]), 2.5);
  EXPECT_GT(std::log2(coarse[2] / fine[2]), 1.5);
}

TEST(MtlTable, HasNoValueSlopeAndCurvatureAtRest) {
  const MtlTable t = table(16);
  for (const double size : {0.0, 1e-8, 1e-4}) {
    const double e[3] = {size, -0.4 * size, 0.7 * size};
    const LogResponse<double> r = t.evaluate<true>(e);
    EXPECT_LE(std::abs(r.psi), 20 * size * size * size + 1e-11);
    for (int i = 0; i < 3; ++i) EXPECT_LE(std::abs(r.w[i]), 20 * size * size + 1e-9) << size;
    for (int c = 0; c < 6; ++c) EXPECT_LE(std::abs(r.ww[c]), 20 * size + 1e-7) << size;
  }
}

TEST(MtlTable, DerivativesAreThoseOfItsValue) {
  const MtlTable t = table(16);
  const std::vector<double> e = strains(200, 50, 1.2, 4);
  constexpr double kStep = 1e-6;
  for (size_t k = 0; k < 200; ++k)
    for (size_t m = 0; m < 3; ++m) {
      double up[3], down[3];
      for (size_t i = 0; i < 3; ++i) up[i] = down[i] = e[3 * k + i];
      up[m] += kStep, down[m] -= kStep;
      const LogResponse<double> here = t.evaluate<true>(e.data() + 3 * k);
      const LogResponse<double> a = t.evaluate<false>(up), b = t.evaluate<false>(down);
      EXPECT_NEAR((a.psi - b.psi) / (2 * kStep), here.w[m], 1e-8);
      EXPECT_NEAR((a.w[m] - b.w[m]) / (2 * kStep), here.ww[m], 1e-4);  // w is C1 at knots
      EXPECT_NEAR((a.w[(m + 1) % 3] - b.w[(m + 1) % 3]) / (2 * kStep), here.ww[3 + m], 1e-4);
    }
}

TEST(MtlTable, IsTheSameForEveryOrderOfTheStretches) {
  const MtlTable t = table(16);
  const std::vector<double> e = strains(200, 50, 1, 3);
  for (size_t k = 0; k < 200; ++k) {
    const double a[3] = {e[3 * k], e[3 * k + 1], e[3 * k + 2]}, b[3] = {a[1], a[0], a[2]};
    const LogResponse<double> first = t.evaluate<true>(a), swapped = t.evaluate<true>(b);
    EXPECT_NEAR(first.psi, swapped.psi, 1e-14);
    EXPECT_NEAR(first.w[0], swapped.w[1], 1e-13);
    EXPECT_NEAR(first.ww[4], swapped.ww[5], 1e-11);
  }
}

TEST(MtlTable, EndsSmoothlyAndIsZeroBeyond) {
  const MtlTable t = table(16);
  for (const double far : {1.75, 3.0, 1e30, std::numeric_limits<double>::infinity()})
    for (const double sign : {-1.0, 1.0}) {
      const double e[3] = {sign * far, 0.1, -0.2};
      const LogResponse<double> r = t.evaluate<true>(e);
      EXPECT_EQ(r.psi, 0) << far;
      EXPECT_EQ(r.w[0], 0) << far;
      EXPECT_EQ(r.ww[0], 0) << far;
    }
  // steps of 1e-4 along a line never change value, slope and curvature by more than a C2 function
  LogResponse<double> last{};
  for (double x = 1.8; x > 0.8; x -= 1e-4) {
    const double e[3] = {x, 0.1, -0.2};
    const LogResponse<double> r = t.evaluate<true>(e);
    EXPECT_NEAR(r.psi, last.psi, 1e-3);
    EXPECT_NEAR(r.w[0], last.w[0], 1e-2);
    EXPECT_NEAR(r.ww[0], last.ww[0], 0.1);
    last = r;
  }
}

TEST(MtlTable, GivesTheSameInPacks) {
  const MtlTable t = table(16);
  const std::vector<double> e = strains(kLanes, 2, 0.9, 0.69);
  Pack<double> packed[3];
  Pack<float> single[3];
  for (int l = 0; l < kLanes; ++l)
    for (int i = 0; i < 3; ++i) {
      packed[i][l] = e[size_t(3 * l + i)];
      single[i][l] = float(e[size_t(3 * l + i)]);
    }
  const LogResponse<Pack<double>> r = t.evaluate<true>(packed);
  const LogResponse<Pack<float>> f = t.evaluate<true>(single);
  for (int l = 0; l < kLanes; ++l) {
    const LogResponse<double> one = t.evaluate<true>(e.data() + 3 * l);
    EXPECT_EQ(r.psi[l], one.psi);
    EXPECT_EQ(r.w[1][l], one.w[1]);
    EXPECT_EQ(r.ww[5][l], one.ww[5]);
    EXPECT_NEAR(double(f.w[1][l]), one.w[1], 1e-5);
  }
}

}  // namespace
}  // namespace elastogen::test
