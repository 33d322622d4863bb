// SPDX-License-Identifier: Apache-2.0
#include "diffusion/material_family.hpp"

#include "training/strain_sampler.hpp"

#include <cmath>
#include <utility>

namespace elastogen {
namespace {

constexpr uint64_t kFamilyStream = 0x6d61'7465'7269'616c;  // not the draws of strains

double rounded(double value, double digits) {
  return std::round(value * digits) / digits;
}

/// Random numbers of one material, in [0, 1).
class Draws {
 public:
  Draws(uint64_t seed, uint64_t number) : seed_(~seed ^ kFamilyStream), number_(number) {}
  double next() { return counted_uniform(seed_, number_, draw_++); }
  double next(double low, double high) { return low + (high - low) * next(); }

 private:
  uint64_t seed_, number_, draw_ = 0;
};

/// A mixture of some of the five laws, with random weights of sum 1.
std::vector<LawTerm> mixture(Draws& draws, int count) {
  Law laws[] = {Law::kFixedCorotated, Law::kNeoHookean, Law::kStableNeoHookean, Law::kStvk,
                Law::kHencky};
  std::vector<LawTerm> terms;
  double left = 1;
  for (int k = 0; k < count; ++k) {
    std::swap(laws[k], laws[k + int(draws.next() * (5 - k))]);
    const bool last = k == count - 1;
    // a term leaves at least a tenth of the rest to the next one
    const double weight = last ? left : rounded(left * draws.next(0.1, 0.9), 1e4);
    terms.push_back({laws[k], rounded(weight, 1e4)});
    left -= weight;
  }
  return terms;
}

std::vector<LawTerm> random_terms(Draws& draws) {
  const double kind = draws.next();
  if (kind < 0.30) return mixture(draws, 1);
  if (kind < 0.70) return mixture(draws, draws.next() < 0.5 ? 2 : 3);
  const double u = draws.next();
  if (kind < 0.85) return {{Law::ogden(rounded(-4 + 12 * u, 1e4)), 1}};
  if (kind < 0.92) return {{Law::mooney_rivlin(rounded(u, 1e4)), 1}};
  return {{Law::gent(rounded(12 * std::pow(200.0 / 12, u), 1e3)), 1}};
}

}  // namespace

const char* group_name(MaterialGroup group) {
  switch (group) {
    case MaterialGroup::kOgden:
      return "Ogden";
    case MaterialGroup::kMooneyRivlin:
      return "Mooney-Rivlin";
    case MaterialGroup::kGent:
      return "Gent";
    default:
      return "five laws and sums of them";
  }
}

FitMaterial family_material(uint64_t seed, uint64_t number) {
  Draws draws(seed, number);
  const std::vector<LawTerm> terms = random_terms(draws);
  const bool even = draws.next() < 0.5;
  const double u = draws.next();
  return fit_material(law_text(terms),
                      rounded(even ? 0.495 * u : (1 - std::pow(0.01, u)) / 2, 1e6));
}

MaterialGroup group_of(const FitMaterial& material) {
  for (const LawTerm& term : material.terms) {
    if (term.law.kind == Law::Kind::kOgden) return MaterialGroup::kOgden;
    if (term.law.kind == Law::Kind::kMooneyRivlin) return MaterialGroup::kMooneyRivlin;
    if (term.law.kind == Law::Kind::kGent) return MaterialGroup::kGent;
  }
  return MaterialGroup::kFiveLaws;
}

}  // namespace elastogen
