// SPDX-License-Identifier: Apache-2.0
#include "training/fit_material.hpp"

#include "core/error.hpp"
#include "training/cells.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <set>
#include <sstream>

namespace elastogen {
namespace {

/// The shortest text that reads back as this number.
std::string shortest(double value) {
  char text[32];
  return std::string(text, std::to_chars(text, text + sizeof text, value).ptr);
}

FitMaterial material_of_line(const std::string& line) {
  const std::vector<std::string> cells = split(line, ',');
  ELASTOGEN_CHECK(cells.size() == 3, "expected 'name, law, nu', got '", line, "'");
  FitMaterial material = fit_material(cells[1], number(cells[2]));
  constexpr auto kLetters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_.";
  ELASTOGEN_CHECK(!cells[0].empty() && cells[0].find_first_not_of(kLetters) == std::string::npos &&
                      cells[0][0] != '.',
                  "'", cells[0], "' is no name: letters, digits, '-', '_' and '.' are");
  material.name = cells[0];
  return material;
}

}  // namespace

std::vector<LawTerm> law_terms(const std::string& text) {
  std::vector<LawTerm> terms;
  double sum = 0;
  for (const std::string& part : split(text, '+')) {
    const size_t star = part.find('*');
    const bool alone = star == std::string::npos;
    const double weight = alone ? 1 : number(trimmed(part.substr(0, star)));
    terms.push_back({law_from_name(alone ? part : trimmed(part.substr(star + 1))), weight});
    ELASTOGEN_CHECK(weight > 0, "law '", text, "': weights are above 0");
    sum += weight;
  }
  ELASTOGEN_CHECK(!terms.empty() && terms.size() <= kMaxLawTerms, "law '", text, "': 1 to ",
                  kMaxLawTerms, " terms are possible");
  ELASTOGEN_CHECK(std::abs(sum - 1) < 1e-6, "law '", text, "': weights must sum to 1, got ", sum);
  return terms;
}

std::string law_text(const std::vector<LawTerm>& terms) {
  std::string text;
  for (const LawTerm& term : terms) {
    if (!text.empty()) text += '+';
    if (terms.size() > 1) text += shortest(term.weight) + '*';
    text += law_name(term.law);
  }
  return text;
}

FitMaterial fit_material(const std::string& law, double poisson) {
  ELASTOGEN_CHECK(poisson >= 0 && poisson <= 0.499,
                  "Poisson's ratio of a fit must lie in [0, 0.499], got ", poisson);
  FitMaterial material{"", law_terms(law), poisson};
  material.name = law_text(material.terms) + "-" + shortest(poisson);
  return material;
}

std::vector<FitMaterial> read_fit_materials(const std::string& text, const std::string& source) {
  std::vector<FitMaterial> materials;
  std::set<std::string> names;
  std::istringstream stream(text);
  int number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    line = trimmed(line.substr(0, line.find('#')));
    if (line.empty()) continue;
    try {
      materials.push_back(material_of_line(line));
    } catch (const Error& error) {
      throw Error(concat(source, ", line ", number, ": ", error.what()), ErrorKind::kAsset);
    }
    ELASTOGEN_CHECK_ASSET(names.insert(materials.back().name).second, source, ", line ", number,
                          ": '", materials.back().name, "' occurs twice");
  }
  ELASTOGEN_CHECK_ASSET(!materials.empty(), source, ": no materials");
  return materials;
}

double least_limit(const FitMaterial& material) {
  double least = std::numeric_limits<double>::infinity();
  for (const LawTerm& term : material.terms)
    if (term.law.kind == Law::Kind::kGent) least = std::min(least, term.law.shape);
  return least;
}

TargetLaw target_law(const FitMaterial& material) {
  ELASTOGEN_CHECK(!material.terms.empty() && material.terms.size() <= kMaxLawTerms, "material '",
                  material.name, "': 1 to ", kMaxLawTerms, " laws are possible");
  TargetLaw target{};
  for (const LawTerm& term : material.terms) {
    target.law[target.terms] = {term.law, material.mu(), material.lambda()};
    target.weight[target.terms++] = term.weight;
  }
  return target;
}

}  // namespace elastogen
