// SPDX-License-Identifier: Apache-2.0
// Reverse diffusion from noise to a sample, by a denoiser that predicts the end x_0. With
//
//   x_t = sqrt(A_t) x_0 + sqrt(1 - A_t) noise,  t = 0 ... T,  A_t = cos^2((t/T + s)/(1 + s) pi/2)
//   divided by its value at t = 0, s = 0.008 (Nichol, Dhariwal 2021), each A_t/A_{t-1} at least
//   1e-3
//
// DDPM (Ho et al. 2020) draws x_{t-1} from the posterior given x_t and x_0; DDIM (Song et al. 2021)
// keeps the noise that x_t and x_0 imply. The noise depends on the seed only.

#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace elastogen {

inline constexpr int kNoiseSteps = 200;  ///< T

/// A_0 = 1 ... A_T, (T + 1). @throws Error (usage) unless T is positive.
std::vector<double> noise_schedule(int steps = kNoiseSteps);

/// Writes the x_0 predicted from x_t, both of one size.
using Denoise = std::function<void(std::span<const double> x, int t, std::span<double> x0)>;

/// Standard normal number, from a seed and counters (Box-Muller).
double counted_normal(uint64_t seed, uint64_t number, uint64_t draw);

/// Samples of `size` numbers.
/// @param steps  number of values of t, evenly from T to 0. @throws Error (usage) unless 1 ... T.
std::vector<double> sample_ddim(const Denoise& denoise, int64_t size, uint64_t seed, int steps,
                                const std::vector<double>& schedule);
std::vector<double> sample_ddpm(const Denoise& denoise, int64_t size, uint64_t seed,
                                const std::vector<double>& schedule);

}  // namespace elastogen
