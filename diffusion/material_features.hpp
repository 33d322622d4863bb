// SPDX-License-Identifier: Apache-2.0
// A material's place among others, in numbers. Generators of weights know only these of it.

#pragma once

#include "training/fit_material.hpp"

#include <vector>

namespace elastogen {

inline constexpr int kMaterialFeatures = 15;

/// Features of a material, (15), with w the weights of its laws and nu Poisson's ratio:
///
///   0 ... 7   sum of w over the terms of each law, in the order of Law::Kind
///   8, 9      sum of w a/4 and w (a/4)^2 over Ogden's terms, a the exponent
///   10        sum of w r over Mooney-Rivlin's terms, r the share
///   11        sum of w 10/L over Gent's terms, L the limit
///   12, 13    s = sqrt((1 - 2 nu)/(1 + nu)) = sqrt(2 mu/(3 K)), and 1/(1 - nu)
///   14        s times the weight of StVK, whose volume term needs K/mu
std::vector<double> material_features(const FitMaterial& material);

/// |x - y|^2 of features, (15) each.
double feature_distance(const double* x, const double* y);

}  // namespace elastogen
