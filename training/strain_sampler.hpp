// SPDX-License-Identifier: Apache-2.0
// Strains to fit and to judge NeuralMTL on: principal log stretches e = ln sigma, half of them
// uniform in the box, half on spheres around rest whose radius is log-uniform from 1e-4 to the box.
// Each strain is a function of (seed, number), so that any batch can be drawn again.

#pragma once

#include "core/array.hpp"
#include "core/base.hpp"
#include "training/fit_material.hpp"

#include <limits>
#include <span>

namespace elastogen {

/// |e_i| <= stretch, |e_0 + e_1 + e_2| <= volume and I1 - 3 <= invariant, I1 = sum exp(2 e'_i).
struct StrainBox {
  double stretch, volume;
  double invariant = std::numeric_limits<double>::infinity();

  /// @param slack  is added to stretch and volume, and times 10 to the invariant.
  bool contains(const double e[3], double slack = 0) const;
};

/// Where the errors of a fit are stated: stretches of e^0.9, volumes halved to doubled,
inline constexpr StrainBox kDeclaredBox = {0.9, 0.693147180559945309};
/// of Gent's law up to 0.9 of its limit, where its logarithm ends (the least limit of a sum).
StrainBox declared_box(const FitMaterial& material);

/// Where fits are made; wider, because psi_theta is blended into the law between the two,
inline constexpr StrainBox kFitBox = {1.0, 0.8};
/// and cut like the declared one; by the least limit of several materials at once.
StrainBox fit_box(std::span<const FitMaterial> materials);

/// A number in (0, 1) that depends on its three arguments alone.
double counted_uniform(uint64_t seed, uint64_t number, uint64_t draw);

/// Strains number first .. first + count - 1 of a seed, (count, 3); even numbers are of the box,
/// odd ones of spheres. A trace beyond its range is moved to the end of it.
Array<double> sample_strains(const StrainBox& box, uint64_t seed, uint64_t first, int64_t count);

}  // namespace elastogen
