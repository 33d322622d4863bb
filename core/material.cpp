// SPDX-License-Identifier: Apache-2.0
#include "core/material.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace elastogen {
namespace {

/// Name of a law, and the range of its shape parameter; no range: it has none.
struct LawEntry {
  Law::Kind kind;
  std::string_view name;
  double least = 0, most = 0;

  bool family() const { return least < most; }
};

constexpr std::array<LawEntry, 8> kLaws = {{
    {Law::Kind::kFixedCorotated, "fixed-corotated"},
    {Law::Kind::kNeoHookean, "neo-hookean"},
    {Law::Kind::kStableNeoHookean, "stable-neo-hookean"},
    {Law::Kind::kStvk, "stvk"},
    {Law::Kind::kHencky, "hencky"},
    {Law::Kind::kOgden, "ogden", -20, 20},
    {Law::Kind::kMooneyRivlin, "mooney-rivlin", 0, 1},
    {Law::Kind::kGent, "gent", 0.1, 1e6},
}};

const LawEntry& entry_of(const Law& law) {
  for (const LawEntry& entry : kLaws)
    if (entry.kind == law.kind) return entry;
  throw Error("unknown law");
}

// moduli at small strain and room temperature; engineering handbooks give ranges, these lie inside
const std::array<MaterialPreset, 8> kPresets = {{
    {{"rubber", Law::kNeoHookean, 1.5e6, 0.48, 1100},
     "literature",
     "unfilled natural rubber, E 1-2 MPa: Treloar, The Physics of Rubber Elasticity",
     0.05,
     10,
     "tan(delta) of unfilled natural rubber at room temperature, 0.03-0.1: Ferry, Viscoelastic "
     "Properties of Polymers"},
    {{"soft-rubber", Law::kNeoHookean, 2e5, 0.47, 1070},
     "literature",
     "silicone Ecoflex 00-30, 100 % modulus 69 kPa to 0.2 MPa: maker's data sheet, rounded",
     0.1,
     10,
     "soft silicones at 1-10 Hz, 0.05-0.2: Ferry"},
    {{"jelly", Law::kStableNeoHookean, 2e4, 0.45, 1050},
     "literature",
     "gelatine gel of 10 %, E 10-30 kPa; nu lowered from 0.5 for speed",
     0.1,
     10,
     "gelatine gels at 1-10 Hz, 0.02-0.1, and softer ones above: Ferry"},
    {{"foam", Law::kNeoHookean, 5e4, 0.1, 60},
     "literature",
     "open-cell polyurethane foam: Gibson, Ashby, Cellular Solids",
     0.2,
     10,
     "flexible polyurethane foams, 0.1-0.5: Gibson, Ashby, Cellular Solids"},
    {{"flesh", Law::kStableNeoHookean, 3e4, 0.45, 1060},
     "literature",
     "relaxed muscle and fat, E 10-60 kPa in indentation; nu lowered from 0.5 for speed",
     0.2,
     10,
     "muscle and fat at 1-10 Hz, 0.1-0.3: Fung, Biomechanics"},
    {{"leather", Law::kNeoHookean, 5e7, 0.4, 900},
     "literature",
     "cowhide at small strain, E 20-100 MPa",
     0.1,
     10,
     "loss coefficients of leather, 0.05-0.2: Ashby, Materials Selection in Mechanical Design"},
    {{"wood", Law::kFixedCorotated, 1e10, 0.3, 600},
     "literature",
     "softwood along the grain, taken as isotropic",
     0.008,
     100,
     "softwood along the grain, 0.005-0.012: Ashby, Materials Selection in Mechanical Design"},
    {{"plush", Law::kNeoHookean, 1.5e4, 0.2, 120},
     "look",
     "chosen by eye for stuffed toys",
     0.3,
     10,
     "chosen by eye"},
}};

// ranges of handbooks at room temperature; soils and snow as in simulations of them
const std::array<MaterialPreset, 9> kYielding = {{
    {{"sand", Law::kHencky, 3.5e5, 0.3, 2200},
     "literature",
     "E, nu, rho about those of Klar et al. 2016, far softer than grains are; friction angle of "
     "dry "
     "sand, 30-38 degrees"},
    {{"wet-sand", Law::kHencky, 3.5e5, 0.3, 2000},
     "look",
     "sand with a cohesion chosen by eye, a tip at 0.9 kPa of tension"},
    {{"snow", Law::kHencky, 1e6, 0.3, 300},
     "literature",
     "within the ranges of Gaume et al. 2018 and Li et al. 2020: E 1-3 MPa, p0 3-30 kPa, M to "
     "1.85"},
    {{"packed-snow", Law::kHencky, 3e6, 0.3, 400},
     "look",
     "the stiff end of the same ranges with p0 of 30 kPa and more cohesion, chosen by eye"},
    {{"clay", Law::kHencky, 3e5, 0.25, 1700},
     "literature",
     "plasticine of Ma et al. 2023 (NCLaw): E, nu, |dev tau| of 5 kPa, here as the stress of a "
     "bar"},
    {{"aluminium", Law::kHencky, 6.9e10, 0.33, 2700},
     "literature",
     "alloy 6061-T6: yield 276 MPa; H such that 7 % of strain reach the ultimate 310 MPa"},
    {{"copper", Law::kHencky, 1.17e11, 0.34, 8960},
     "literature",
     "annealed copper: yield 33-70 MPa; H from the ultimate 220 MPa at about 30 % of strain"},
    {{"lead", Law::kHencky, 1.6e10, 0.44, 11340},
     "literature",
     "pure lead: yield 5-12 MPa, ultimate 12-18 MPa at about 40 % of strain"},
    {{"steel", Law::kHencky, 2e11, 0.29, 7850},
     "literature",
     "mild steel: yield 250 MPa, ultimate 400-500 MPa at about 20 % of strain"},
}};

}  // namespace

std::string law_name(const Law& law) {
  const LawEntry& entry = entry_of(law);
  if (!entry.family()) return std::string(entry.name);
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits, law.shape).ptr;
  return concat(entry.name, '=', std::string_view(digits, end));
}

std::vector<std::string> law_names() {
  std::vector<std::string> names;
  for (const LawEntry& entry : kLaws)
    names.push_back(std::string(entry.name) + (entry.family() ? "=NUMBER" : ""));
  return names;
}

Law law_from_name(std::string_view text) {
  const size_t equals = text.find('=');
  const std::string_view name = text.substr(0, equals);
  std::string known;
  for (const LawEntry& entry : kLaws)
    if (entry.name == name && entry.family() == (equals != text.npos)) {
      if (!entry.family()) return {entry.kind};
      const std::string_view number = text.substr(equals + 1);
      double shape = 0;
      const auto [end, error] =
          std::from_chars(number.data(), number.data() + number.size(), shape);
      ELASTOGEN_CHECK(error == std::errc() && end == number.data() + number.size() &&
                          shape >= entry.least && shape <= entry.most,
                      "law '", text, "': ", name, "=NUMBER takes a number from ", entry.least,
                      " to ", entry.most);
      return {entry.kind, shape};
    }
  for (const std::string& other : law_names()) known += (known.empty() ? "" : ", ") + other;
  throw Error(concat("unknown law '", text, "'; known are ", known));
}

std::span<const MaterialPreset> material_presets() {
  return kPresets;
}

std::span<const MaterialPreset> yielding_presets() {
  return kYielding;
}

const MaterialPreset& material_preset(std::string_view name) {
  std::string known;
  for (const MaterialPreset& preset : kPresets) {
    if (preset.material.name == name) return preset;
    known += (known.empty() ? "" : ", ") + preset.material.name;
  }
  throw Error(concat("unknown material '", name, "'; known are ", known));
}

void check_material(const Material& m) {
  ELASTOGEN_CHECK(std::isfinite(m.young) && m.young > 0, "material '", m.name,
                  "': Young's modulus must be positive, got ", m.young, " Pa");
  ELASTOGEN_CHECK(m.poisson >= 0 && m.poisson < 0.5, "material '", m.name,
                  "': Poisson's ratio must lie in [0, 0.5), got ", m.poisson);
  ELASTOGEN_CHECK(std::isfinite(m.density) && m.density > 0, "material '", m.name,
                  "': density must be positive, got ", m.density, " kg/m^3");
  const double loss = m.loss_factor.value_or(0);
  ELASTOGEN_CHECK(loss >= 0 && loss <= 10, "material '", m.name,
                  "': the loss factor lies between 0 and 10, got ", loss);
  ELASTOGEN_CHECK(std::isfinite(m.loss_frequency) && m.loss_frequency > 0, "material '", m.name,
                  "': the frequency of the loss factor must be positive, got ", m.loss_frequency,
                  " Hz");
  const LawEntry& entry = entry_of(m.law);
  ELASTOGEN_CHECK(m.law.shape >= entry.least && m.law.shape <= entry.most, "material '", m.name,
                  "': the shape parameter of ", entry.name, " lies between ", entry.least, " and ",
                  entry.most, ", got ", m.law.shape);
}

double contact_young(const Material& material, double v) {
  return std::max(material.young, 8 * material.density * v * v);
}

}  // namespace elastogen
