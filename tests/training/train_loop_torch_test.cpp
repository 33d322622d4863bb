// SPDX-License-Identifier: Apache-2.0
#include "diffusion/train_loop_torch.hpp"

#include "core/error.hpp"
#include "io/safe_file.hpp"

#include <ATen/ATen.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>

namespace elastogen {
namespace {

LoopOptions plain(int64_t steps) {
  LoopOptions options;
  options.steps = steps;
  options.rate = 0.1;
  options.warm_up = 1;
  options.decay = 0.2;
  options.identity = "a test";
  return options;
}

/// 3/2 |w - 1|^2 of the only parameter.
at::Tensor bowl(const Parameters& w, int64_t) {
  return 1.5 * (w[0] - 1).square().sum();
}

double number(const at::Tensor& tensor, int64_t k = 0) {
  return tensor[k].item<double>();
}

TEST(TrainLoop, TakesTheStepsOfAdamW) {
  // by its formulas, in double
  double w = 3, m = 0, v = 0, a = 3;
  for (int k = 1; k <= 4; ++k) {
    const double g = 3 * (w - 1), rate = 0.1 * (1 + std::cos(std::numbers::pi * (k - 1) / 4)) / 2;
    m = 0.9 * m + 0.1 * g, v = 0.999 * v + 0.001 * g * g;
    w -= rate * 0.2 * w;
    w -= rate * m / (1 - std::pow(0.9, k)) / (std::sqrt(v / (1 - std::pow(0.999, k))) + 1e-8);
    const double kept = std::min(0.999, (1.0 + k) / (10.0 + k));
    a = kept * a + (1 - kept) * w;
  }
  LoopOptions options = plain(4);
  const Parameters start = {at::full({1}, 3.0)};
  EXPECT_NEAR(number(train_loop(start, bowl, options, {}).parameters[0]), w, 1e-6);
  options.average = 0.999;
  EXPECT_NEAR(number(train_loop(start, bowl, options, {}).parameters[0]), a, 1e-6);
  EXPECT_EQ(number(start[0]), 3);  // the start stays as it was
}

TEST(TrainLoop, RaisesTheRateOverTheFirstSteps) {
  // the first step of Adam has the size of the rate, a quarter of the largest here
  LoopOptions options = plain(1'000'000);
  options.decay = 0, options.warm_up = 4;
  int asked = 0;
  FitHooks hooks;
  hooks.stopped = [&] { return ++asked > 1; };
  const LoopOutcome outcome = train_loop({at::full({1}, 3.0)}, bowl, options, hooks);
  EXPECT_EQ(outcome.steps, 1);
  EXPECT_NEAR(number(outcome.parameters[0]), 3 - 0.025, 1e-6);
}

TEST(TrainLoop, GoesOnFromItsCheckpointWithTheSameBits) {
  const auto folder = std::filesystem::temp_directory_path() / "elastogen-train-loop";
  std::filesystem::create_directories(folder);
  LoopOptions options = plain(40);
  options.average = 0.9;
  const Parameters start = {at::tensor({3.f, -2.f})};
  const StepLoss noisy = [](const Parameters& w, int64_t step) {
    at::Generator random = step_generator(5, step);
    return (w[0] - at::randn({2}, random)).square().sum();
  };
  const LoopOutcome whole = train_loop(start, noisy, options, {});
  options.checkpoint = (folder / "a.part").string();
  options.checkpoint_steps = 4;
  int asked = 0;
  FitHooks hooks;
  hooks.stopped = [&] { return ++asked > 14; };
  EXPECT_EQ(train_loop(start, noisy, options, hooks).steps, 14);
  options.resume = true;
  const LoopOutcome again = train_loop(start, noisy, options, {});
  EXPECT_EQ(again.steps, 40);
  EXPECT_TRUE(at::equal(again.parameters[0], whole.parameters[0]));
  // a checkpoint of another run is refused
  options.identity = "another test";
  EXPECT_THROW(train_loop(start, noisy, options, {}), Error);
  options.identity = "a test";
  EXPECT_THROW(train_loop({at::zeros({3})}, noisy, options, {}), Error);
  EXPECT_THROW(train_loop({at::zeros({2}), at::zeros({2})}, noisy, options, {}), Error);
  write_file(options.checkpoint, "elastogen-tensor");
  EXPECT_THROW(train_loop(start, noisy, options, {}), Error);
  std::filesystem::remove_all(folder);
}

TEST(TrainLoop, RejectsWhatItsDocumentationForbids) {
  const Parameters start = {at::zeros({1})};
  EXPECT_THROW(train_loop({}, bowl, plain(3), {}), Error);
  EXPECT_THROW(train_loop(start, bowl, plain(0), {}), Error);
  LoopOptions options = plain(3);
  options.rate = 0;
  EXPECT_THROW(train_loop(start, bowl, options, {}), Error);
}

TEST(AddLinear, DrawsWithinTheRootOfTheInputs) {
  at::Generator random = step_generator(1, -1), same = step_generator(1, -1),
                other = step_generator(2, -1);
  Parameters a, b, c;
  add_linear(a, 30, 100, random, at::kCPU);
  add_linear(b, 30, 100, same, at::kCPU);
  add_linear(c, 30, 100, other, at::kCPU);
  EXPECT_TRUE(at::equal(a[0], b[0]));
  EXPECT_FALSE(at::equal(a[0], c[0]));
  EXPECT_LE(a[0].abs().max().item<double>(), 0.1);
  EXPECT_GT(a[0].abs().max().item<double>(), 0.099);
  EXPECT_NEAR(a[0].square().mean().item<double>(), 0.01 / 3, 3e-4);
  EXPECT_EQ(a[1].abs().max().item<double>(), 0);
}

}  // namespace
}  // namespace elastogen
