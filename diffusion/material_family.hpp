// SPDX-License-Identifier: Apache-2.0
// Random materials for which weights are made and on which they are judged, from a family that
// covers all laws. Material number n of a seed depends on these two numbers only.
//
//   30 %  one of the five laws without a shape      40 %  sums of two or three of them
//   15 %  Ogden, exponent uniform in [-4, 8]         7 %  Mooney-Rivlin, share uniform in [0, 1]
//    8 %  Gent, limit log-uniform in [12, 200]
//
// Poisson's ratio is uniform in [0, 0.495] for half of them; for the others 1 - 2 nu is log-uniform
// in [0.01, 1].

#pragma once

#include "training/fit_material.hpp"

namespace elastogen {

/// Parts of the family for which results are given separately.
enum class MaterialGroup { kFiveLaws, kOgden, kMooneyRivlin, kGent };

inline constexpr MaterialGroup kMaterialGroups[] = {MaterialGroup::kFiveLaws, MaterialGroup::kOgden,
                                                    MaterialGroup::kMooneyRivlin,
                                                    MaterialGroup::kGent};

const char* group_name(MaterialGroup group);

/// Material number n of a seed. Weights, shapes and Poisson's ratio are rounded to few digits, so
/// that its name is short.
FitMaterial family_material(uint64_t seed, uint64_t number);

/// The part of a material: of its first law with a shape, else the five laws.
MaterialGroup group_of(const FitMaterial& material);

}  // namespace elastogen
