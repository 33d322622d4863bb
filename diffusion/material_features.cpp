// SPDX-License-Identifier: Apache-2.0
#include "diffusion/material_features.hpp"

#include <cmath>

namespace elastogen {

std::vector<double> material_features(const FitMaterial& material) {
  std::vector<double> x(kMaterialFeatures);
  // sums over the laws, by kind and by shape
  for (const LawTerm& term : material.terms) {
    const double w = term.weight, shape = term.law.shape;
    x[size_t(term.law.kind)] += w;
    switch (term.law.kind) {
      case Law::Kind::kOgden:
        x[8] += w * shape / 4;
        x[9] += w * shape * shape / 16;
        break;
      case Law::Kind::kMooneyRivlin:
        x[10] += w * shape;
        break;
      case Law::Kind::kGent:
        x[11] += w * 10 / shape;
        break;
      default:
        break;
    }
  }
  // Poisson's ratio
  x[12] = std::sqrt((1 - 2 * material.poisson) / (1 + material.poisson));
  x[13] = 1 / (1 - material.poisson);
  x[14] = x[12] * x[size_t(Law::Kind::kStvk)];
  return x;
}

double feature_distance(const double* x, const double* y) {
  double sum = 0;
  for (int k = 0; k < kMaterialFeatures; ++k) sum += (x[k] - y[k]) * (x[k] - y[k]);
  return sum;
}

}  // namespace elastogen
