// SPDX-License-Identifier: Apache-2.0
// Strains to fit and to judge NeuralMTL on: principal log stretches e = ln sigma. Half of them are
// uniform in the box, half lie on spheres around rest with radii log-uniform from 1e-4 to the box.
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

  /// @param slack  is added to stretch and volume; ten times slack is added to the invariant.
  bool contains(const double e[3], double slack = 0) const;
};

/// Box for which the errors of a fit are stated: stretches up to e^0.9, volumes halved to doubled.
inline constexpr StrainBox kDeclaredBox = {0.9, 0.693147180559945309};
/// kDeclaredBox, for Gent's law cut at 0.9 of its limit, where its logarithm ends; of a sum the
/// least.
StrainBox declared_box(const FitMaterial& material);

/// Box in which fits are made; wider, as psi_theta is blended into the law between the two boxes.
inline constexpr StrainBox kFitBox = {1.0, 0.8};
/// kFitBox, cut like declared_box by the least limit of several materials.
StrainBox fit_box(std::span<const FitMaterial> materials);

/// A number in (0, 1) that depends on its three arguments only.
double counted_uniform(uint64_t seed, uint64_t number, uint64_t draw);

/// Strains with numbers first .. first + count - 1 of a seed, (count, 3). Even numbers are uniform
/// in the box, odd ones lie on spheres. A trace outside its range is moved to the end of the range.
Array<double> sample_strains(const StrainBox& box, uint64_t seed, uint64_t first, int64_t count);

}  // namespace elastogen
