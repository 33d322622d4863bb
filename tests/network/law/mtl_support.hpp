// SPDX-License-Identifier: Apache-2.0
// Strains of the box that nets are fitted in, weights drawn at random, laws in log stretches.

#pragma once

#include "network/law/learned_law.hpp"
#include "tests/support/laws.hpp"

#include <algorithm>
#include <random>

namespace elastogen::test {

/// Log stretches in the box |e_i| <= size, |tr e| <= trace; `small` of them on spheres around rest
/// whose radius is log-uniform in 1e-4 ... size.
inline std::vector<double> strains(int count, int small, double size, double trace,
                                   uint64_t seed = 1) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::normal_distribution<double> normal;
  std::vector<double> result;
  while (int(result.size()) < 3 * count) {
    double e[3];
    if (int(result.size()) < 3 * small) {
      const double radius = std::exp(std::log(1e-4) * (uniform(random) + 1) / 2) * size;
      double length = 0;
      for (double& value : e) value = normal(random), length += value * value;
      for (double& value : e) value *= radius / std::sqrt(length);
    } else {
      for (double& value : e) value = size * uniform(random);
    }
    if (std::abs(e[0] + e[1] + e[2]) <= trace) result.insert(result.end(), e, e + 3);
  }
  return result;
}

/// Weights with the spread of a fresh net of width 128.
inline std::vector<float> random_weights(uint64_t seed = 1) {
  std::mt19937_64 random(seed);
  std::normal_distribution<float> normal;
  std::vector<float> w(size_t(NeuralMtl::kParameters));
  for (size_t k = 0; k < w.size(); ++k) w[k] = normal(random) * (k < 512 ? 0.5f : 0.09f);
  return w;
}

/// w_i = t_i s_i and w_ij = H_ij s_i s_j + d_ij w_i of a law with E = 1.
inline LogJet in_logs(Law law, double poisson, const double e[3]) {
  constexpr int kFirst[6] = {0, 1, 2, 0, 1, 2}, kSecond[6] = {0, 1, 2, 1, 2, 0};
  double s[3];
  for (int i = 0; i < 3; ++i) s[i] = std::exp(e[i]);
  const Response<double> r = elastic_response<true>(parameters<double>(law, 1, poisson), s);
  LogJet jet;
  jet.psi = r.psi;
  for (int i = 0; i < 3; ++i) jet.w[i] = r.t[i] * s[i];
  for (int c = 0; c < 6; ++c)
    jet.ww[c] = r.H[c] * s[kFirst[c]] * s[kSecond[c]] + (c < 3 ? jet.w[c] : 0);
  return jet;
}

/// Euclidean length of n numbers.
inline double length(const double* v, int n) {
  double sum = 0;
  for (int k = 0; k < n; ++k) sum += v[k] * v[k];
  return std::sqrt(sum);
}

/// The value below which a share of the numbers lies.
inline double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[size_t(share * double(values.size() - 1))];
}

}  // namespace elastogen::test
