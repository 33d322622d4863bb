// SPDX-License-Identifier: Apache-2.0
// On which of the shipped hidden layers the last layer of a material is fitted.

#pragma once

#include "training/fit_material.hpp"

#include <algorithm>

namespace elastogen {

/// Name of the file with the hidden layers that nets are fitted on.
inline constexpr const char* kHiddenLayers = "hidden.tensors";
/// Those of Gent's law with limits below 12, whose singularity is near or within the box.
inline constexpr const char* kGentHiddenLayers = "hidden-gent.tensors";
/// Those of sums of St. Venant-Kirchhoff's law and others above nu = 0.48. The one holds trace E,
/// the others ln J at 0, and the sum is stiff between the two: its q turns within strains of about
/// sqrt(mu / lambda) about rest, sharper than that of any single law.
inline constexpr const char* kSumHiddenLayers = "hidden-sums.tensors";

/// Whether the limit of Gent's law is so near that fits need layers and iterations of their own.
inline bool near_limit(const FitMaterial& material) {
  return least_limit(material) < 12;
}

/// Which of the three files a material is fitted on.
inline const char* hidden_layers_of(const FitMaterial& material) {
  if (near_limit(material)) return kGentHiddenLayers;
  const bool stvk =
      std::any_of(material.terms.begin(), material.terms.end(),
                  [](const LawTerm& term) { return term.law.kind == Law::Kind::kStvk; });
  return stvk && material.terms.size() > 1 && material.poisson > 0.48 ? kSumHiddenLayers
                                                                      : kHiddenLayers;
}

}  // namespace elastogen
