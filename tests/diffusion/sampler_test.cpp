// SPDX-License-Identifier: Apache-2.0
#include "diffusion/sampler.hpp"

#include "core/error.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <cmath>

namespace elastogen {
namespace {

/// E[x_0 | x_t] for x_0 of a normal distribution: m + sqrt(A) S (A S + (1 - A) I)^-1 (x - sqrt(A)
/// m).
struct Gaussian {
  Eigen::Vector2d mean{1.5, -0.5};
  Eigen::Matrix2d covariance{{0.8, 0.5}, {0.5, 0.6}};

  Denoise denoiser(const std::vector<double>& schedule) const {
    return [this, &schedule](std::span<const double> x, int t, std::span<double> x0) {
      const double A = schedule[size_t(t)];
      const Eigen::Vector2d at(x[0], x[1]);
      const Eigen::Matrix2d spread = A * covariance + (1 - A) * Eigen::Matrix2d::Identity();
      const Eigen::Vector2d result =
          mean + std::sqrt(A) * covariance * spread.inverse() * (at - std::sqrt(A) * mean);
      x0[0] = result[0], x0[1] = result[1];
    };
  }
};

/// Mean and covariance of samples against those of the distribution.
template <class Sample>
void expect_moments(const Gaussian& exact, int count, double bias, const Sample& sample) {
  Eigen::MatrixXd all(count, 2);
  for (int n = 0; n < count; ++n) {
    const std::vector<double> x = sample(uint64_t(n));
    all.row(n) << x[0], x[1];
  }
  const Eigen::RowVector2d mean = all.colwise().mean();
  const Eigen::MatrixXd rest = all.rowwise() - mean;
  const Eigen::Matrix2d covariance = rest.transpose() * rest / count;
  const double error = 5 / std::sqrt(double(count)) + bias;  // of sampling, and of the steps
  EXPECT_LT((mean.transpose() - exact.mean).cwiseAbs().maxCoeff(), error) << mean;
  EXPECT_LT((covariance - exact.covariance).cwiseAbs().maxCoeff(), error) << covariance;
}

TEST(NoiseSchedule, FallsFromOneToNextToNothing) {
  const std::vector<double> A = noise_schedule();
  ASSERT_EQ(A.size(), 201u);
  EXPECT_EQ(A[0], 1);
  for (size_t t = 1; t < A.size(); ++t) EXPECT_LT(A[t], A[t - 1]);
  EXPECT_LT(A[200], 1e-5);
  const double s = 0.008, half = std::acos(-1.0) / 2;
  const auto c = [&](double x) { return std::pow(std::cos((x + s) / (1 + s) * half), 2); };
  EXPECT_NEAR(A[100], c(0.5) / c(0), 1e-12);
  EXPECT_THROW(noise_schedule(0), Error);
}

TEST(CountedNormal, HasTheMomentsOfANormalNumber) {
  double sum[5] = {};
  constexpr int kCount = 40000;
  for (int k = 0; k < kCount; ++k) {
    const double x = counted_normal(3, uint64_t(k) / 7, uint64_t(k) % 7);
    for (int p = 1; p < 5; ++p) sum[p] += std::pow(x, p) / kCount;
  }
  EXPECT_NEAR(sum[1], 0, 5 * std::sqrt(1.0 / kCount));
  EXPECT_NEAR(sum[2], 1, 5 * std::sqrt(2.0 / kCount));
  EXPECT_NEAR(sum[3], 0, 5 * std::sqrt(15.0 / kCount));
  EXPECT_NEAR(sum[4], 3, 5 * std::sqrt(96.0 / kCount));
}

TEST(Sampler, EndsAtWhatAPerfectDenoiserKnows) {
  const std::vector<double> schedule = noise_schedule();
  const Denoise knows = [](std::span<const double>, int, std::span<double> x0) {
    for (size_t k = 0; k < x0.size(); ++k) x0[k] = double(k) - 1.25;
  };
  const std::vector<double> expected = {-1.25, -0.25, 0.75};
  for (const int steps : {1, 7, 50, 200}) {
    const std::vector<double> x = sample_ddim(knows, 3, 5, steps, schedule);
    for (size_t k = 0; k < 3; ++k) EXPECT_NEAR(x[k], expected[k], 1e-14);
  }
  const std::vector<double> x = sample_ddpm(knows, 3, 5, schedule);
  for (size_t k = 0; k < 3; ++k) EXPECT_NEAR(x[k], expected[k], 1e-14);
}

TEST(Sampler, DrawsFromTheDistributionOfAnExactDenoiser) {
  const Gaussian exact;
  const std::vector<double> schedule = noise_schedule();
  const Denoise denoise = exact.denoiser(schedule);
  expect_moments(exact, 20000, 0.01,
                 [&](uint64_t n) { return sample_ddpm(denoise, 2, n, schedule); });
  expect_moments(exact, 20000, 0.02,
                 [&](uint64_t n) { return sample_ddim(denoise, 2, n, 200, schedule); });
}

TEST(Sampler, IsAFunctionOfTheSeed) {
  const Gaussian exact;
  const std::vector<double> schedule = noise_schedule();
  const Denoise denoise = exact.denoiser(schedule);
  EXPECT_EQ(sample_ddim(denoise, 2, 4, 50, schedule), sample_ddim(denoise, 2, 4, 50, schedule));
  EXPECT_NE(sample_ddim(denoise, 2, 4, 50, schedule), sample_ddim(denoise, 2, 5, 50, schedule));
  EXPECT_EQ(sample_ddpm(denoise, 2, 4, schedule), sample_ddpm(denoise, 2, 4, schedule));
  EXPECT_THROW(sample_ddim(denoise, 2, 4, 0, schedule), Error);
  EXPECT_THROW(sample_ddim(denoise, 2, 4, 201, schedule), Error);
}

}  // namespace
}  // namespace elastogen
