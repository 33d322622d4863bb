// SPDX-License-Identifier: Apache-2.0
#include "diffusion/autoencoder_torch.hpp"

#include "core/error.hpp"
#include "training/strain_sampler.hpp"

#include <ATen/ATen.h>
#include <gtest/gtest.h>

#include <cmath>

namespace elastogen {
namespace {

constexpr int kWeights = 24;

/// Nets that two numbers decide; weights 5 and 11 are the same in all.
Array<float> some_nets(int64_t count, uint64_t seed) {
  Array<float> nets(count, kWeights);
  for (int64_t n = 0; n < count; ++n) {
    const double a = 2 * counted_uniform(seed, uint64_t(n), 0) - 1,
                 b = 2 * counted_uniform(seed, uint64_t(n), 1) - 1;
    for (int k = 0; k < kWeights; ++k)
      nets(n, k) = float(100 + 10 * std::sin(k) * a + std::cos(2 * k) * b * (1 + 0.3 * a));
    nets(n, 5) = 0.1f, nets(n, 11) = 0;
  }
  return nets;
}

AutoencoderOptions autoencoder_training(int64_t steps) {
  AutoencoderOptions options;
  options.loop.steps = steps;
  options.loop.rate = 5e-3;
  options.loop.warm_up = 20;
  options.batch = 32;
  return options;
}

TEST(Autoencoder, HasTheSizesOfThePaper) {
  EXPECT_EQ((std::vector<int64_t>{8192, 4096, 2048, 1024, 512, 256}), AutoencoderOptions().layers);
}

TEST(Autoencoder, LearnsAFamilyOfTwoNumbers) {
  const Array<float> nets = some_nets(200, 1), unseen = some_nets(40, 2);
  Autoencoder autoencoder(nets, {16, 2}, 1, at::kCPU);
  const double before = autoencoder.error(unseen);
  ASSERT_TRUE(autoencoder.train(nets, autoencoder_training(2500), {}));
  EXPECT_NEAR(before, 1, 0.3);  // nothing learned: the mean, off by one standard deviation
  EXPECT_LT(autoencoder.error(unseen), 0.12);
  const Array<double> codes = autoencoder.encode(unseen);
  EXPECT_EQ(codes.cols(), 2);
  const Array<float> again = autoencoder.decode(codes);
  double square = 0, spread = 0;
  for (int64_t n = 0; n < 40; ++n) {
    EXPECT_EQ(again(n, 5), 0.1f);
    EXPECT_EQ(again(n, 11), 0);
    square += std::pow(again(n, 1) - unseen(n, 1), 2);
    spread += std::pow(unseen(n, 1) - 100, 2);
  }
  EXPECT_LT(square, 0.05 * spread);
}

TEST(Autoencoder, IsTheNetOfItsFile) {
  // decoded by loops from the tensors of the file: W3, b3, W4, b4 of 24-3-2-3-24
  const Array<float> nets = some_nets(20, 1);
  const Autoencoder autoencoder(nets, {3, 2}, 7, at::kCPU);
  TensorFile file;
  autoencoder.write(file);
  file = decode_tensors(encode_tensors(file), "a");
  Array<double> code(1, 2);
  code(0, 0) = 0.7, code(0, 1) = -1.1;
  const auto layer = [&](const std::vector<double>& a, int number, int64_t rows) {
    const auto columns = int64_t(a.size());
    const std::string name = std::to_string(number);
    const std::vector<float>& W = file.get("autoencoder.W" + name, {rows, columns}).values;
    const std::vector<float>& b = file.get("autoencoder.b" + name, {rows}).values;
    std::vector<double> z(b.begin(), b.end());
    for (int64_t r = 0; r < rows; ++r)
      for (int64_t c = 0; c < columns; ++c)
        z[size_t(r)] += W[size_t(r * columns + c)] * a[size_t(c)];
    return z;
  };
  std::vector<double> hidden = layer({0.7, -1.1}, 3, 3);
  for (double& z : hidden) z /= 1 + std::exp(-z);
  const std::vector<double> out = layer(hidden, 4, kWeights);
  const std::vector<float>& mean = file.get("autoencoder.mean", {kWeights}).values;
  const std::vector<float>& scale = file.get("autoencoder.scale", {kWeights}).values;
  const Array<float> decoded = autoencoder.decode(code);
  for (size_t k = 0; k < kWeights; ++k)
    EXPECT_NEAR(decoded(0, int(k)), mean[k] + scale[k] * out[k], 1e-4);
  const Autoencoder again(file, at::kCPU);
  EXPECT_EQ(again.decode(code), decoded);
  EXPECT_EQ(again.encode(nets), autoencoder.encode(nets));
  EXPECT_EQ(again.error(nets), autoencoder.error(nets));
}

TEST(Autoencoder, RefusesFilesThatLackSomething) {
  TensorFile whole;
  Autoencoder(some_nets(20, 1), {3, 2}, 7, at::kCPU).write(whole);
  for (size_t k = 0; k < whole.tensors.size(); ++k) {
    TensorFile file = whole;
    file.tensors.erase(file.tensors.begin() + int64_t(k));
    EXPECT_THROW(Autoencoder(file, at::kCPU), Error) << whole.tensors[k].name;
  }
  for (const auto& [name, value] : whole.text)
    for (const char* other : {"0", "-3", "99999999", "x"}) {
      TensorFile file = whole;
      file.text[name] = other;
      EXPECT_THROW(Autoencoder(file, at::kCPU), Error) << name << " = " << other;
    }
}

TEST(Autoencoder, RejectsWhatItsDocumentationForbids) {
  const Array<float> nets = some_nets(20, 1);
  EXPECT_THROW(Autoencoder(nets, {}, 1, at::kCPU), Error);
  EXPECT_THROW(Autoencoder(nets, {4, 0}, 1, at::kCPU), Error);
  EXPECT_THROW(Autoencoder(Array<float>(0, kWeights), {4}, 1, at::kCPU), Error);
  Autoencoder autoencoder(nets, {4}, 1, at::kCPU);
  EXPECT_THROW(autoencoder.train(Array<float>(4, 3), autoencoder_training(2), {}), Error);
  FitHooks hooks;
  hooks.stopped = [] { return true; };
  EXPECT_FALSE(autoencoder.train(nets, autoencoder_training(2), hooks));
}

}  // namespace
}  // namespace elastogen
