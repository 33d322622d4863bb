// SPDX-License-Identifier: Apache-2.0
// Numbers in the PLY files of 3-D Gaussian splats (Kerbl et al. 2023) for those of a SplatCloud:
// logit of the opacity, log of the scale, harmonics channel by channel.

#pragma once

#include <algorithm>
#include <cmath>

namespace elastogen {

/// Y_00 = 1 / (2 sqrt(pi)): a splat's colour is 1/2 + Y_00 times its first coefficient.
inline constexpr double kHarmonic0 = 0.28209479177387814;

/// 1 / (1 + exp(-logit)), 0 ... 1; infinite logits give 0 and 1.
inline float opacity_of_logit(float logit) {
  return float(1 / (1 + std::exp(-double(logit))));
}

/// log(a / (1 - a)) of an opacity a, clamped to 2^-24 from 0 and 1 so that it is finite.
inline float logit_opacity(float opacity) {
  const double a = std::clamp(double(opacity), 0x1p-24, 1 - 0x1p-24);
  return float(std::log(a / (1 - a)));
}

inline float scale_of_log(float log_scale) {
  return float(std::exp(double(log_scale)));
}

/// Logarithm of a standard deviation > 0.
inline float log_scale(float scale) {
  return float(std::log(double(scale)));
}

/// First coefficient of a colour channel 0 ... 1 that is independent of the view.
inline float harmonic_of_colour(double colour) {
  return float((colour - 0.5) / kHarmonic0);
}

/// Coefficients of one channel for harmonics up to a degree.
inline constexpr int harmonic_count(int degree) {
  return (degree + 1) * (degree + 1);
}

/// k of the property f_rest_k that holds a coefficient (1 ... harmonic_count(degree) - 1) of a
/// channel (0 red, 1 green, 2 blue): all of red, then green, then blue.
inline constexpr int f_rest_index(int degree, int coefficient, int channel) {
  return channel * (harmonic_count(degree) - 1) + coefficient - 1;
}

}  // namespace elastogen
