// SPDX-License-Identifier: Apache-2.0
// The choice of the shipped hidden layers on which the last layer of a material is fitted.

#pragma once

#include "training/fit_material.hpp"

#include <algorithm>

namespace elastogen {

/// File with the hidden layers for nearly all materials.
inline constexpr const char* kHiddenLayers = "hidden.tensors";
/// File for Gent's law with limits below 12, whose singularity lies near or within the box.
inline constexpr const char* kGentHiddenLayers = "hidden-gent.tensors";
/// File for sums of St. Venant-Kirchhoff's law with others above nu = 0.48. The former keeps trace
/// E at 0, the latter ln J, and the sum is stiff between the two: its q turns within strains of
/// about sqrt(mu / lambda) around rest, more sharply than that of any single law.
inline constexpr const char* kSumHiddenLayers = "hidden-sums.tensors";

/// Whether the limit of Gent's law is so near that fits need their own layers and iterations.
inline bool near_limit(const FitMaterial& material) {
  return least_limit(material) < 12;
}

/// The name of the file on which a material is fitted.
inline const char* hidden_layers_of(const FitMaterial& material) {
  if (near_limit(material)) return kGentHiddenLayers;
  const bool stvk =
      std::any_of(material.terms.begin(), material.terms.end(),
                  [](const LawTerm& term) { return term.law.kind == Law::Kind::kStvk; });
  return stvk && material.terms.size() > 1 && material.poisson > 0.48 ? kSumHiddenLayers
                                                                      : kHiddenLayers;
}

}  // namespace elastogen
