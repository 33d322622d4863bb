// SPDX-License-Identifier: Apache-2.0
#include "diffusion/denoiser_torch.hpp"

#include "core/error.hpp"
#include "training/strain_sampler.hpp"

#include <ATen/ATen.h>
#include <gtest/gtest.h>

#include <cmath>

namespace elastogen {
namespace {

/// Codes that are a function of two features, or one of two at random where `split`.
struct Data {
  Array<double> codes, features;
};

Data some_data(int64_t count, bool split) {
  Data data{Array<double>(count, 4), Array<double>(count, 2)};
  for (int64_t n = 0; n < count; ++n) {
    const auto draw = [&](uint64_t k) { return counted_uniform(2, uint64_t(n), k); };
    const double f = 2 * draw(0) - 1, sign = split && draw(1) < 0.25 ? -1 : 1;
    data.features(n, 0) = 10 + 3 * f, data.features(n, 1) = 5;
    const double code[] = {f, -f, f * f, 1};
    for (int c = 0; c < 4; ++c) data.codes(n, c) = sign * code[c];
  }
  return data;
}

DenoiserOptions denoiser_training(int64_t steps) {
  DenoiserOptions options;
  options.loop.steps = steps;
  options.loop.rate = 3e-3;
  options.loop.warm_up = 20;
  options.batch = 64;
  options.width = 32;
  return options;
}

TEST(TrainDenoiser, LearnsWhatTheFeaturesSay) {
  const Data data = some_data(256, false);
  const auto denoiser = train_denoiser(data.codes, data.features, denoiser_training(1500), {});
  ASSERT_TRUE(denoiser);
  const Denoise denoise = [&](std::span<const double> x, int t, std::span<double> x0) {
    const std::vector<float> features = {11.2f, 5};  // f = 0.4
    const std::vector<float> result =
        denoiser->x0(std::vector<float>(x.begin(), x.end()), t, features);
    std::copy(result.begin(), result.end(), x0.begin());
  };
  const double exact[] = {0.4, -0.4, 0.16, 1};
  for (uint64_t seed = 0; seed < 4; ++seed) {
    const std::vector<double> x = sample_ddim(denoise, 4, seed, 50, noise_schedule());
    for (size_t c = 0; c < 4; ++c) EXPECT_NEAR(x[c], exact[c], 0.1) << seed;
  }
}

TEST(TrainDenoiser, SamplesEachOfTwoAnswersAsOftenAsItIsGiven) {
  // a regression would answer with the mean, which neither of them is
  const Data data = some_data(512, true);
  const auto denoiser = train_denoiser(data.codes, data.features, denoiser_training(1500), {});
  ASSERT_TRUE(denoiser);
  const Denoise denoise = [&](std::span<const double> x, int t, std::span<double> x0) {
    const std::vector<float> features = {11.2f, 5};
    const std::vector<float> result =
        denoiser->x0(std::vector<float>(x.begin(), x.end()), t, features);
    std::copy(result.begin(), result.end(), x0.begin());
  };
  int above = 0, clear = 0;
  constexpr int kSamples = 200;
  for (uint64_t seed = 0; seed < kSamples; ++seed) {
    const double last = sample_ddim(denoise, 4, seed, 50, noise_schedule())[3];
    above += last > 0;
    clear += std::abs(std::abs(last) - 1) < 0.3;
  }
  EXPECT_NEAR(above / double(kSamples), 0.75, 0.15);
  EXPECT_GT(clear, 0.8 * kSamples);
}

TEST(TrainDenoiser, StopsAndRejects) {
  const Data data = some_data(16, false);
  FitHooks hooks;
  hooks.stopped = [] { return true; };
  EXPECT_FALSE(train_denoiser(data.codes, data.features, denoiser_training(5), hooks));
  EXPECT_THROW(train_denoiser(data.codes, Array<double>(3, 2), denoiser_training(5), {}), Error);
  DenoiserOptions options = denoiser_training(5);
  options.batch = 0;
  EXPECT_THROW(train_denoiser(data.codes, data.features, options, {}), Error);
  options = denoiser_training(5);
  options.device = "tpu";
  EXPECT_THROW(train_denoiser(data.codes, data.features, options, {}), Error);
}

using Image = std::vector<std::vector<double>>;  // channels of side * side

/// 3 x 3 convolution with zeros around, by loops.
Image convolved(const Image& from, const at::Tensor& W, const at::Tensor& b, int side) {
  Image to;
  for (int64_t o = 0; o < W.size(0); ++o) {
    to.emplace_back(side * side, b[o].item<double>());
    for (size_t i = 0; i < from.size(); ++i)
      for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x)
          for (int dy = -1; dy <= 1; ++dy)
            for (int dx = -1; dx <= 1; ++dx) {
              if (y + dy < 0 || y + dy >= side || x + dx < 0 || x + dx >= side) continue;
              to.back()[size_t(y * side + x)] += W[o][int64_t(i)][dy + 1][dx + 1].item<double>() *
                                                 from[i][size_t((y + dy) * side + x + dx)];
            }
  }
  return to;
}

double silu(double z) {
  return z / (1 + std::exp(-z));
}

Image activated(Image image) {
  for (auto& channel : image)
    for (double& value : channel) value = silu(value);
  return image;
}

std::vector<double> linear(const std::vector<double>& a, const at::Tensor& W, const at::Tensor& b) {
  std::vector<double> z;
  for (int64_t r = 0; r < W.size(0); ++r) {
    z.push_back(b[r].item<double>());
    for (size_t c = 0; c < a.size(); ++c) z.back() += W[r][int64_t(c)].item<double>() * a[c];
  }
  return z;
}

TEST(ConvDenoiser, IsTheNetOfItsFormula) {
  constexpr int kSide = 3, kChannels = 2, kTime = 17;
  const ConvDenoiser denoiser(kSide, kChannels, {{0, 0}, {1, 1}}, 4, at::kCPU);
  const Parameters& p = denoiser.parameters();
  std::vector<double> x, features = {0.3, -0.7};
  // image and condition
  for (int k = 0; k < kSide * kSide; ++k) x.push_back(2 * counted_uniform(9, 0, uint64_t(k)) - 1);
  std::vector<double> c;
  for (const float value : time_embedding(kTime)) c.push_back(value);
  c.insert(c.end(), features.begin(), features.end());
  c = linear(c, p[0], p[1]);
  for (double& value : c) value = silu(value);
  // the blocks, by loops
  Image h = convolved({x}, p[2], p[3], kSide);
  for (size_t k = 0; k < ConvDenoiser::kBlocks; ++k) {
    const Parameters q(p.begin() + int64_t(4 + 6 * k), p.end());
    Image inner = convolved(activated(h), q[0], q[1], kSide);
    const std::vector<double> shift = linear(c, q[2], q[3]);
    for (size_t o = 0; o < inner.size(); ++o)
      for (double& value : inner[o]) value += shift[o];
    inner = convolved(activated(inner), q[4], q[5], kSide);
    for (size_t o = 0; o < h.size(); ++o)
      for (size_t at = 0; at < h[o].size(); ++at) h[o][at] += inner[o][at];
  }
  const Image expected = convolved(activated(h), p[p.size() - 2], p[p.size() - 1], kSide);
  // against libtorch
  const at::Tensor got =
      denoiser.x0(p, tensor_of({x.data(), 1, kSide * kSide}, at::kCPU),
                  at::full({1}, kTime, at::kLong), tensor_of({features.data(), 1, 2}, at::kCPU));
  ASSERT_EQ(got.numel(), kSide * kSide);
  for (int k = 0; k < kSide * kSide; ++k)
    EXPECT_NEAR(got[0][k].item<double>(), expected[0][size_t(k)], 1e-5);
}

TEST(ConvDenoiser, LearnsWhatTheFeaturesSay) {
  const Data data = some_data(256, false);  // images of 2 x 2
  DenoiserOptions options = denoiser_training(600);
  options.loop.rate = 1e-2;
  ConvDenoiser denoiser(2, 12, feature_scale(data.features), 1, at::kCPU);
  ASSERT_TRUE(denoiser.train(data.codes, data.features, options, {}));
  const double features[] = {11.2, 5}, exact[] = {0.4, -0.4, 0.16, 1};
  const std::vector<double> x = denoiser.sample(features, 3);
  for (size_t c = 0; c < 4; ++c) EXPECT_NEAR(x[c], exact[c], 0.2);
  EXPECT_EQ(denoiser.sample(features, 3), x);
  EXPECT_THROW(denoiser.train(Array<double>(256, 9), data.features, options, {}), Error);
}

}  // namespace
}  // namespace elastogen
