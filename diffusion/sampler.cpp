// SPDX-License-Identifier: Apache-2.0
#include "diffusion/sampler.hpp"

#include "core/error.hpp"
#include "training/strain_sampler.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace elastogen {
namespace {

constexpr double kOffset = 0.008, kLeastStep = 1e-3;
constexpr uint64_t kNoiseStream = 0x6e6f'6973'65;  // keeps draws apart from those of strains

std::vector<double> noise(int64_t size, uint64_t seed, uint64_t number) {
  std::vector<double> x;
  for (int64_t k = 0; k < size; ++k) x.push_back(counted_normal(seed, number, uint64_t(k)));
  return x;
}

}  // namespace

std::vector<double> noise_schedule(int steps) {
  ELASTOGEN_CHECK(steps > 0, "the steps of diffusion must be positive, got ", steps);
  const auto at = [&](int t) {
    const double c = std::cos((double(t) / steps + kOffset) / (1 + kOffset) * std::numbers::pi / 2);
    return c * c;
  };
  std::vector<double> A = {1};
  for (int t = 1; t <= steps; ++t) A.push_back(A.back() * std::max(at(t) / at(t - 1), kLeastStep));
  return A;
}

double counted_normal(uint64_t seed, uint64_t number, uint64_t draw) {
  const double u = counted_uniform(seed ^ kNoiseStream, number, 2 * draw),
               v = counted_uniform(seed ^ kNoiseStream, number, 2 * draw + 1);
  return std::sqrt(-2 * std::log(u)) * std::cos(2 * std::numbers::pi * v);
}

std::vector<double> sample_ddim(const Denoise& denoise, int64_t size, uint64_t seed, int steps,
                                const std::vector<double>& schedule) {
  const int last = int(schedule.size()) - 1;
  ELASTOGEN_CHECK(steps >= 1 && steps <= last, "steps of a sampler must lie in 1 ... ", last,
                  ", got ", steps);
  std::vector<double> x = noise(size, seed, 0), x0(x.size());
  for (int k = steps; k > 0; --k) {
    const int t = last * k / steps, next = last * (k - 1) / steps;
    denoise(x, t, x0);
    const double A = schedule[size_t(t)], B = schedule[size_t(next)];
    const double kept = std::sqrt((1 - B) / (1 - A));
    for (size_t i = 0; i < x.size(); ++i)
      x[i] = std::sqrt(B) * x0[i] + kept * (x[i] - std::sqrt(A) * x0[i]);
  }
  return x;
}

std::vector<double> sample_ddpm(const Denoise& denoise, int64_t size, uint64_t seed,
                                const std::vector<double>& schedule) {
  std::vector<double> x = noise(size, seed, 0), x0(x.size());
  for (int t = int(schedule.size()) - 1; t > 0; --t) {
    denoise(x, t, x0);
    const double A = schedule[size_t(t)], B = schedule[size_t(t - 1)], step = A / B;
    const double of_x0 = std::sqrt(B) * (1 - step) / (1 - A),
                 of_x = std::sqrt(step) * (1 - B) / (1 - A),
                 spread = std::sqrt((1 - step) * (1 - B) / (1 - A));
    const std::vector<double> z = noise(size, seed, uint64_t(t));
    for (size_t i = 0; i < x.size(); ++i) x[i] = of_x0 * x0[i] + of_x * x[i] + spread * z[i];
  }
  return x;
}

}  // namespace elastogen
