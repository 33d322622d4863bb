// SPDX-License-Identifier: Apache-2.0
#include "core/pack_functions.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

namespace elastogen {
namespace {

/// Largest error of log_1p on a pack relative to the logarithm, in eps, over x.
template <class S>
double log_error(const std::vector<double>& xs) {
  double worst = 0;
  for (size_t k = 0; k + kLanes <= xs.size(); k += kLanes) {
    Pack<S> x;
    for (int lane = 0; lane < kLanes; ++lane) x[lane] = S(xs[k + lane]);
    const Pack<S> y = log_1p(x);
    for (int lane = 0; lane < kLanes; ++lane) {
      const long double exact = std::log1p(static_cast<long double>(x[lane]));
      const long double error = std::abs(y[lane] - exact) / std::abs(exact);
      worst = std::max(worst, double(error / std::numeric_limits<S>::epsilon()));
    }
  }
  return worst;
}

/// Numbers between -1 and 1e30: near 0 from both sides, near -1, and large.
std::vector<double> arguments(int per_range, double smallest) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<double> xs;
  for (int k = 0; k < per_range; ++k) {
    const double small = std::pow(smallest, unit(random));
    xs.insert(xs.end(), {small / 2, -small / 2, small - 1, 2 * unit(random) - 0.999,
                         std::pow(1e30, unit(random)), 0.5 * unit(random) - 0.3});
  }
  return xs;
}

TEST(Log1p, HoldsFourEpsRelativeInDouble) {
  EXPECT_LE(log_error<double>(arguments(40000, 1e-15)), 4);
}

TEST(Log1p, HoldsFourEpsRelativeInFloat) {
  EXPECT_LE(log_error<float>(arguments(40000, 1e-6)), 4);
}

TEST(Log1p, IsExactAtZeroAndKeepsTinyNumbers) {
  Pack<double> x = {0, 1e-300, -1e-300, 1e-20, -1e-20, 5e-17, 1, -0.5};
  const Pack<double> y = log_1p(x);
  for (int lane = 0; lane < 6; ++lane) EXPECT_DOUBLE_EQ(y[lane], x[lane]);
  EXPECT_DOUBLE_EQ(y[6], std::log(2.0));
  EXPECT_DOUBLE_EQ(y[7], -std::log(2.0));
}

/// Largest relative error of exponential on a pack over [-80, 80], in eps, the argument being
/// exact.
template <class S>
double exponential_error() {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<S> wide(-80, 80), near(-1e-3, 1e-3);
  double worst = 0;
  for (int n = 0; n < 5000; ++n) {
    Pack<S> x;
    for (int lane = 0; lane < kLanes; ++lane) x[lane] = lane % 2 ? wide(random) : near(random);
    const Pack<S> y = exponential(x);
    for (int lane = 0; lane < kLanes; ++lane) {
      const long double exact = std::exp(static_cast<long double>(x[lane]));
      const long double error = std::abs(y[lane] - exact) / exact;
      worst = std::max(worst, double(error / std::numeric_limits<S>::epsilon()));
    }
  }
  return worst;
}

TEST(Exponential, HoldsFourEpsRelative) {
  EXPECT_LE(exponential_error<double>(), 4);
  EXPECT_LE(exponential_error<float>(), 4);
}

TEST(Exponential, IsOneAtZeroAndNothingFarBelow) {
  const Pack<double> x = {0, -1e300, -1e3, -80, 1, -1, 80, -0.0};
  const Pack<double> y = exponential(x);
  EXPECT_EQ(y[0], 1);
  EXPECT_EQ(y[7], 1);
  for (int lane = 1; lane < 4; ++lane) EXPECT_LE(y[lane], 2e-35);
  for (int lane = 1; lane < 4; ++lane) EXPECT_GE(y[lane], 0);
  EXPECT_DOUBLE_EQ(y[4], std::exp(1.0));
}

TEST(Pack, FunctionsActLaneByLane) {
  const float from[kLanes] = {4, -9, 0.25f, 1, -0.0f, 16, -2, 3};
  const Pack<float> a = load(from), b = constant<Pack<float>>(1);
  const Pack<float> size = absolute(a), root = square_root(size);
  const Pack<float> most = larger(a, b), least = smaller(a, b);
  float back[kLanes];
  store(back, a);
  for (int k = 0; k < kLanes; ++k) {
    EXPECT_EQ(back[k], from[k]);
    EXPECT_EQ(size[k], std::abs(from[k]));
    EXPECT_EQ(root[k], std::sqrt(std::abs(from[k])));
    EXPECT_EQ(most[k], std::max(from[k], 1.0f));
    EXPECT_EQ(least[k], std::min(from[k], 1.0f));
  }
}

TEST(Pack, AnySeesEachLane) {
  for (int k = 0; k < kLanes; ++k) {
    Pack<double> a{};
    EXPECT_FALSE(any(a > 0));
    a[k] = 1;
    EXPECT_TRUE(any(a > 0));
  }
  EXPECT_TRUE(any(1.0 > 0.0));
  EXPECT_FALSE(any(1.0 < 0.0));
}

TEST(Pack, KnowsTheTypeOfItsLanes) {
  static_assert(std::is_same_v<Scalar<Pack<float>>, float>);
  static_assert(std::is_same_v<Scalar<double>, double>);
  static_assert(is_pack<Pack<double>> && !is_pack<double>);
  EXPECT_EQ(sizeof(Pack<float>), kLanes * sizeof(float));
  EXPECT_EQ(sizeof(Pack<double>), kLanes * sizeof(double));
}

}  // namespace
}  // namespace elastogen
