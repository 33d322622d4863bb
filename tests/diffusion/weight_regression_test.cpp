// SPDX-License-Identifier: Apache-2.0
#include "diffusion/weight_regression.hpp"

#include "core/error.hpp"
#include "training/strain_sampler.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace elastogen {
namespace {

constexpr int kFeatures = kMaterialFeatures;

const std::vector<double> kOnes(kFeatures, 1.0);

/// Features that vary in two places, floats.
Array<double> some_features(int64_t count) {
  Array<double> x(count, kFeatures);
  for (int64_t n = 0; n < count; ++n)
    for (int k : {2, 12}) x(n, k) = float(counted_uniform(3, uint64_t(n), uint64_t(k)));
  return x;
}

double wave(const double* x) {
  return std::sin(3 * x[2]) + x[2] * x[12];
}

Array<double> waves(const Array<double>& x) {
  Array<double> codes(x.rows(), 2);
  for (int64_t n = 0; n < x.rows(); ++n) codes(n, 0) = wave(x.row(n)), codes(n, 1) = 5;
  return codes;
}

TEST(WeightRegression, IsTheClosedFormOfTwoPoints) {
  // a_1 + k a_2 = 3, k a_1 + a_2 = -1 with k = (1 + r + r^2/3) exp(-r), r = sqrt5 |x - y|/l
  Array<double> x(2, kFeatures), c(2, 1);
  x(1, 4) = 0.75;
  c(0, 0) = 3, c(1, 0) = -1;
  std::vector<double> lengths = kOnes;
  lengths[4] = 1.5;
  const auto matern = [](double d) {
    const double r = std::sqrt(5.0) * d;
    return (1 + r + r * r / 3) * std::exp(-r);
  };
  const double k = matern(0.5), a1 = (3 + k) / (1 - k * k), a2 = (-1 - 3 * k) / (1 - k * k);
  const WeightRegression regression(x, c, lengths);
  std::vector<double> at(kFeatures);
  at[4] = 0.3;
  EXPECT_NEAR(regression.code(at.data())[0], matern(0.2) * a1 + matern(0.3) * a2, 1e-9);
  EXPECT_NEAR(regression.distances(at.data())[1], 0.09, 1e-15);
}

TEST(WeightRegression, TakesWhatItKnows) {
  const Array<double> x = some_features(60), c = waves(x);
  const WeightRegression regression(x, c, kOnes);
  for (int64_t n = 0; n < 60; ++n) {
    const std::vector<double> code = regression.code(x.row(n));
    EXPECT_NEAR(code[0], c(n, 0), 1e-7);
    EXPECT_NEAR(code[1], 5, 1e-7);
  }
}

TEST(WeightRegression, FindsASmoothFunctionBetween) {
  const Array<double> all = some_features(440);
  const auto worst = [&](int64_t known) {
    Array<double> x(known, kFeatures);
    std::copy_n(all.data(), x.size(), x.data());
    const WeightRegression regression(x, waves(x));
    double error = 0;
    for (int64_t n = 400; n < 440; ++n)
      error = std::max(error, std::abs(regression.code(all.row(n))[0] - wave(all.row(n))));
    return error;
  };
  EXPECT_LT(worst(400), 2e-3);
  EXPECT_LT(worst(400), 0.3 * worst(40));
}

TEST(WeightRegression, SearchesLengthsThatPredictBetter) {
  // one feature means nothing: lengths of one must not be better than those found
  Array<double> x = some_features(200);
  for (int64_t n = 0; n < 200; ++n) x(n, 7) = float(counted_uniform(8, uint64_t(n), 7));
  const Array<double> c = waves(x);
  const WeightRegression found(x, c), plain(x, c, kOnes);
  EXPECT_GT(found.lengths()[7], 2 * found.lengths()[2]);
  double error = 0, of_plain = 0;
  for (int64_t n = 0; n < 50; ++n) {
    std::vector<double> at(kFeatures);
    for (const size_t k : {2, 7, 12}) at[k] = counted_uniform(11, uint64_t(n), k);
    error += std::pow(found.code(at.data())[0] - wave(at.data()), 2);
    of_plain += std::pow(plain.code(at.data())[0] - wave(at.data()), 2);
  }
  EXPECT_LT(error, 0.25 * of_plain);
}

TEST(WeightRegression, IsTheSameFromAFile) {
  const Array<double> x = some_features(50);
  const WeightRegression regression(x, waves(x), kOnes);
  TensorFile file;
  regression.write(file);
  const WeightRegression again(decode_tensors(encode_tensors(file), "r"), 2);
  EXPECT_EQ(again.count(), 50);
  std::vector<double> at(kFeatures);
  at[2] = 0.3, at[12] = 0.8;
  EXPECT_NEAR(again.code(at.data())[0], regression.code(at.data())[0], 1e-7);
}

TEST(WeightRegression, BearsAMaterialThatIsThereTwice) {
  Array<double> x = some_features(10), c = waves(x);
  std::copy_n(x.row(0), kFeatures, x.row(1));
  c(1, 0) = c(0, 0);
  EXPECT_NEAR(WeightRegression(x, c, kOnes).code(x.row(0))[0], c(0, 0), 1e-4);
}

TEST(WeightRegression, RejectsOtherSizes) {
  EXPECT_THROW(WeightRegression(Array<double>(0, kFeatures), Array<double>(0, 2)), Error);
  EXPECT_THROW(WeightRegression(Array<double>(3, 4), Array<double>(3, 2)), Error);
  EXPECT_THROW(WeightRegression(Array<double>(3, kFeatures), Array<double>(4, 2)), Error);
  const Array<double> x = some_features(3);
  EXPECT_THROW(WeightRegression(x, waves(x), {1, 2}), Error);
  EXPECT_THROW(WeightRegression(x, waves(x), std::vector<double>(kFeatures, 0.0)), Error);
}

}  // namespace
}  // namespace elastogen
