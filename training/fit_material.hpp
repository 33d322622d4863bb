// SPDX-License-Identifier: Apache-2.0
// The target of a NeuralMTL: a weighted sum of laws at one Poisson ratio. Stiffness is only a
// factor, so Young's modulus is 1. All terms share mu and lambda, and their weights sum to 1.

#pragma once

#include "core/elastic_law.hpp"

#include <string>
#include <vector>

namespace elastogen {

inline constexpr int kMtlParameters = 17153;  ///< 3 -> 128 -> 128 -> 1 with biases
inline constexpr int kMtlLast = 129;          ///< weights of the last layer, w3 and b3
inline constexpr int kMaxLawTerms = 5;

struct LawTerm {
  Law law = Law::kNeoHookean;
  double weight = 1;
};

struct FitMaterial {
  std::string name;
  std::vector<LawTerm> terms;
  double poisson = 0;

  double mu() const { return 1 / (2 * (1 + poisson)); }                            ///< [E]
  double lambda() const { return poisson / ((1 + poisson) * (1 - 2 * poisson)); }  ///< [E]
};

/// The least limit of I1 - 3 among the terms; infinity if none is Gent's law.
double least_limit(const FitMaterial& material);

/// A FitMaterial in the form that loops over strains use.
struct TargetLaw {
  LawParameters<double> law[kMaxLawTerms];
  double weight[kMaxLawTerms];
  int terms;
};

TargetLaw target_law(const FitMaterial& material);

/// Terms of a text like "neo-hookean" or "0.3*neo-hookean+0.7*stvk".
/// @throws Error on unknown laws, more than 5 terms, weights not above 0 or not of sum 1.
std::vector<LawTerm> law_terms(const std::string& text);

/// The text from which law_terms reads these terms.
std::string law_text(const std::vector<LawTerm>& terms);

/// Reads materials from lines "name, law, nu"; # starts a comment.
/// @param source  name for messages. @throws Error (asset) naming the line, also if a name repeats.
std::vector<FitMaterial> read_fit_materials(const std::string& text, const std::string& source);

/// One material, named after its law and Poisson ratio. @throws Error unless 0 <= nu <= 0.499.
FitMaterial fit_material(const std::string& law, double poisson);

}  // namespace elastogen
