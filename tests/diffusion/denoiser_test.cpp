// SPDX-License-Identifier: Apache-2.0
#include "diffusion/denoiser.hpp"

#include "core/error.hpp"
#include "training/strain_sampler.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace elastogen {
namespace {

constexpr DenoiserSizes kSizes{5, 3, 16};

Denoiser::Layers some_layers() {
  Denoiser::Layers layers;
  for (int k = 0; k < kDenoiserLayers; ++k) {
    const int rows = kSizes.rows(k), columns = kSizes.columns(k);
    const auto draw = [&](uint64_t number) {
      return float((2 * counted_uniform(uint64_t(k), number, 0) - 1) / std::sqrt(columns));
    };
    for (int n = 0; n < rows * columns; ++n) layers[size_t(k)].W.push_back(draw(uint64_t(n)));
    for (int n = 0; n < rows; ++n) layers[size_t(k)].b.push_back(draw(uint64_t(1e6) + uint64_t(n)));
  }
  return layers;
}

const FeatureScale kScale = {{1, 2, 3}, {0.5f, 1, 4}};

/// The net by loops, in double.
std::vector<double> by_loops(const std::vector<float>& x, int t, const std::vector<float>& f) {
  std::vector<double> a(x.begin(), x.end());
  for (int k = 0; k < 32; ++k) a.push_back(std::sin(t / std::pow(10000.0, 2 * k / 64.0)));
  for (int k = 0; k < 32; ++k) a.push_back(std::cos(t / std::pow(10000.0, 2 * k / 64.0)));
  for (size_t k = 0; k < 3; ++k) a.push_back((f[k] - kScale.mean[k]) / kScale.scale[k]);
  const Denoiser::Layers layers = some_layers();
  for (size_t l = 0; l < 4; ++l) {
    std::vector<double> z;
    for (size_t r = 0; r < layers[l].b.size(); ++r) {
      z.push_back(layers[l].b[r]);
      for (size_t c = 0; c < a.size(); ++c) z[r] += layers[l].W[r * a.size() + c] * a[c];
      if (l < 3) z[r] = z[r] / (1 + std::exp(-z[r]));
    }
    a = z;
  }
  return a;
}

TEST(Denoiser, IsTheNetOfItsFormula) {
  const Denoiser denoiser(kSizes, some_layers(), kScale);
  const std::vector<float> x = {1, -2, 0.5f, 3, -0.25f}, f = {0.5f, 4, 1};
  for (const int t : {1, 17, 200}) {
    const std::vector<double> expected = by_loops(x, t, f);
    const std::vector<float> got = denoiser.x0(x, t, f);
    ASSERT_EQ(got.size(), 5u);
    for (size_t k = 0; k < 5; ++k) EXPECT_NEAR(got[k], expected[k], 3e-6);
  }
}

TEST(Denoiser, IsTheSameFromAFile) {
  const Denoiser denoiser(kSizes, some_layers(), kScale);
  TensorFile file;
  denoiser.write(file);
  const Denoiser again(decode_tensors(encode_tensors(file), "d"), 5, 3);
  const std::vector<float> x = {1, -2, 0.5f, 3, -0.25f}, f = {0.5f, 4, 1};
  EXPECT_EQ(again.x0(x, 9, f), denoiser.x0(x, 9, f));
}

TEST(Denoiser, ScalesFeaturesByTheirMomentsAndConstantOnesNot) {
  Array<double> features(4, 2);
  for (int64_t n = 0; n < 4; ++n) features(n, 0) = double(n), features(n, 1) = 7;
  const FeatureScale scale = feature_scale(features);
  EXPECT_EQ(scale.mean, (std::vector<float>{1.5f, 7}));
  EXPECT_NEAR(scale.scale[0], std::sqrt(1.25), 1e-6);
  EXPECT_EQ(scale.scale[1], 1);
}

TEST(Denoiser, RejectsOtherSizes) {
  Denoiser::Layers layers = some_layers();
  layers[2].W.pop_back();
  EXPECT_THROW(Denoiser(kSizes, layers, kScale), Error);
  EXPECT_THROW(Denoiser(kSizes, some_layers(), {{1}, {1}}), Error);
  const Denoiser denoiser(kSizes, some_layers(), kScale);
  EXPECT_THROW(denoiser.x0(std::vector<float>(4), 1, std::vector<float>(3)), Error);
  EXPECT_THROW(denoiser.x0(std::vector<float>(5), 1, std::vector<float>(2)), Error);
  TensorFile file;
  denoiser.write(file);
  EXPECT_THROW(Denoiser(file, 6, 3), Error);
  EXPECT_THROW(Denoiser(file, 5, 4), Error);
  for (const char* width : {"15", "0", "-1", "5000", "1e3", "", "99999999999999999999"}) {
    file.text["denoiser.width"] = width;
    EXPECT_THROW(Denoiser(file, 5, 3), Error) << width;
  }
}

}  // namespace
}  // namespace elastogen
