// SPDX-License-Identifier: Apache-2.0
#include "diffusion/weight_codec.hpp"

#include "core/error.hpp"
#include "tests/diffusion/dataset.hpp"
#include "training/last_layer_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace elastogen {
namespace {

constexpr int kCodedWidth = 128;

Array<double> identity() {
  Array<double> metric(kCodedWidth, kCodedWidth);
  for (int k = 0; k < kCodedWidth; ++k) metric(k, k) = 1;
  return metric;
}

/// A A^T + I of numbers in (0, 1).
Array<double> some_metric() {
  Array<double> metric = identity();
  const auto a = [](int i, int k) { return counted_uniform(4, uint64_t(i), uint64_t(k)); };
  for (int i = 0; i < kCodedWidth; ++i)
    for (int j = 0; j < kCodedWidth; ++j)
      for (int k = 0; k < 5; ++k) metric(i, j) += a(i, k) * a(j, k);
  return metric;
}

double product(const Array<double>& metric, const float* a, const float* b) {
  double sum = 0;
  for (int i = 0; i < kCodedWidth; ++i)
    for (int j = 0; j < kCodedWidth; ++j)
      sum += (double(a[i]) - b[i]) * metric(i, j) * (double(a[j]) - b[j]);
  return sum;
}

double distance(const Array<double>& codes, int64_t a, int64_t b) {
  double sum = 0;
  for (int c = 0; c < codes.cols(); ++c) sum += std::pow(codes(a, c) - codes(b, c), 2);
  return sum;
}

std::span<const double> row(const Array<double>& codes, int64_t n) {
  return {codes.row(n), size_t(codes.cols())};
}

TEST(WeightCodec, KeepsTheDistancesOfTheMetric) {
  const Array<float> layers = test::some_dataset(40).layers;
  const Array<double> metric = some_metric();
  const WeightCodec codec(layers, metric, kCodedWidth);
  EXPECT_EQ(codec.components(), 39);  // of 40 layers about their mean
  const Array<double> codes = codec.encode(layers);
  for (int64_t n = 1; n < 40; ++n) {
    const double exact = product(metric, layers.row(0), layers.row(n));
    EXPECT_NEAR(distance(codes, 0, n), exact, 1e-9 * exact);
  }
  EXPECT_LT(codec.lost(), 1e-6);
}

TEST(WeightCodec, DecodesWhatItEncodes) {
  const Array<float> layers = test::some_dataset(40).layers;
  const WeightCodec codec(layers, some_metric(), kCodedWidth);
  const Array<double> codes = codec.encode(layers);
  for (int64_t n = 0; n < 40; ++n) {
    const std::vector<float> again = codec.decode(row(codes, n));
    for (int k = 0; k < kCodedWidth; ++k) EXPECT_NEAR(again[size_t(k)], layers(n, k), 1e-6);
  }
}

TEST(WeightCodec, LosesWhatItsLeftOutComponentsHold) {
  const Array<float> layers = test::some_dataset(40).layers;
  const WeightCodec few(layers, identity(), 7), all(layers, identity(), kCodedWidth);
  ASSERT_EQ(few.components(), 7);
  const Array<double> codes = few.encode(layers), full = all.encode(layers);
  double lost = 0, rest = 0;
  for (int64_t n = 0; n < 40; ++n) {
    const std::vector<float> again = few.decode(row(codes, n));
    for (int k = 0; k < kCodedWidth; ++k) lost += std::pow(again[size_t(k)] - layers(n, k), 2) / 40;
    for (int c = 7; c < 39; ++c) rest += full(n, c) * full(n, c) / 40;
  }
  EXPECT_NEAR(few.lost(), std::sqrt(lost), 1e-6 * few.lost());
  EXPECT_NEAR(few.lost(), std::sqrt(rest), 1e-9 * few.lost());
  for (int c = 0; c < 7; ++c) {
    double square = 0;
    for (int64_t n = 0; n < 40; ++n) square += codes(n, c) * codes(n, c) / 40;
    EXPECT_NEAR(few.scale()[size_t(c)], std::sqrt(square), 1e-9);
    if (c > 0) {
      EXPECT_LE(few.scale()[size_t(c)], few.scale()[size_t(c - 1)]);
    }
  }
}

TEST(WeightCodec, IsTheSameFromAFile) {
  const Array<float> layers = test::some_dataset(20).layers;
  const WeightCodec codec(layers, some_metric(), 9);
  TensorFile file;
  codec.write(file);
  const WeightCodec again(decode_tensors(encode_tensors(file), "c"));
  ASSERT_EQ(again.components(), 9);
  const Array<double> codes = codec.encode(layers), other = again.encode(layers);
  for (int64_t k = 0; k < codes.size(); ++k) EXPECT_NEAR(other.data()[k], codes.data()[k], 1e-11);
  EXPECT_EQ(again.decode(row(codes, 3)), codec.decode(row(codes, 3)));
}

TEST(WeightCodec, MeasuresTheChangeOfTheStress) {
  // three materials on random hidden layers; a step in the code against that of the stresses
  WeightDataset data = test::some_dataset(3);
  for (float& w : std::span(data.layers.data(), size_t(data.layers.size()))) w *= 0.1f;
  const std::optional<WeightCodec> codec = make_codec(data, 2);
  ASSERT_TRUE(codec);
  ASSERT_EQ(codec->components(), 2);
  const Array<double> codes = codec->encode(data.layers);
  const LastLayer layer(data.hidden);
  double expected = 0;
  for (int64_t n = 0; n < 3; ++n) {
    const std::vector<double> w(data.layers.row(n), data.layers.row(n) + kCodedWidth);
    const Array<double> metric = layer.stress_metric(data.materials[size_t(n)], w);
    expected += product(metric, data.layers.row(0), data.layers.row(1)) / 3;
  }
  EXPECT_NEAR(distance(codes, 0, 1), expected, 1e-6 * expected);
}

TEST(WeightCodec, StopsAndRejects) {
  const WeightDataset data = test::some_dataset(3);
  FitHooks hooks;
  hooks.stopped = [] { return true; };
  EXPECT_FALSE(make_codec(data, 2, hooks));
  EXPECT_THROW(WeightCodec(Array<float>(1, kCodedWidth), identity(), 4), Error);
  EXPECT_THROW(WeightCodec(Array<float>(4, 5), identity(), 4), Error);
  EXPECT_THROW(WeightCodec(data.layers, Array<double>(3, 3), 4), Error);
  EXPECT_THROW(WeightCodec(data.layers, identity(), 0), Error);
  Array<double> negative = identity();
  negative(5, 5) = -1;
  EXPECT_THROW(WeightCodec(data.layers, negative, 4), Error);
  const WeightCodec codec(data.layers, identity(), 2);
  EXPECT_THROW(codec.decode(std::vector<double>(3)), Error);
  EXPECT_THROW(codec.encode(Array<float>(1, 5)), Error);
}

}  // namespace
}  // namespace elastogen
