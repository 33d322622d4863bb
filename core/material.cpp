// SPDX-License-Identifier: Apache-2.0
#include "core/material.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace elastogen {
namespace {

constexpr std::array<std::pair<Law, std::string_view>, 5> kLaws = {{
    {Law::kFixedCorotated, "fixed-corotated"},
    {Law::kNeoHookean, "neo-hookean"},
    {Law::kStableNeoHookean, "stable-neo-hookean"},
    {Law::kStvk, "stvk"},
    {Law::kHencky, "hencky"},
}};

// moduli at small strain and room temperature; engineering handbooks give ranges, these lie inside
const std::array<MaterialPreset, 8> kPresets = {{
    {{"rubber", Law::kNeoHookean, 1.5e6, 0.48, 1100},
     "literature",
     "unfilled natural rubber, E 1-2 MPa: Treloar, The Physics of Rubber Elasticity"},
    {{"soft-rubber", Law::kNeoHookean, 2e5, 0.47, 1070},
     "literature",
     "silicone Ecoflex 00-30, 100 % modulus 69 kPa to 0.2 MPa: maker's data sheet, rounded"},
    {{"jelly", Law::kStableNeoHookean, 2e4, 0.45, 1050},
     "literature",
     "gelatine gel of 10 %, E 10-30 kPa; nu lowered from 0.5 for speed"},
    {{"foam", Law::kNeoHookean, 5e4, 0.1, 60},
     "literature",
     "open-cell polyurethane foam: Gibson, Ashby, Cellular Solids"},
    {{"flesh", Law::kStableNeoHookean, 3e4, 0.45, 1060},
     "literature",
     "relaxed muscle and fat, E 10-60 kPa in indentation; nu lowered from 0.5 for speed"},
    {{"leather", Law::kNeoHookean, 5e7, 0.4, 900},
     "literature",
     "cowhide at small strain, E 20-100 MPa"},
    {{"wood", Law::kFixedCorotated, 1e10, 0.3, 600},
     "literature",
     "softwood along the grain, taken as isotropic"},
    {{"plush", Law::kNeoHookean, 1.5e4, 0.2, 120}, "look", "chosen by eye for stuffed toys"},
}};

}  // namespace

std::string_view law_name(Law law) {
  for (const auto& [value, name] : kLaws)
    if (value == law) return name;
  throw Error("unknown law");
}

Law law_from_name(std::string_view name) {
  std::string known;
  for (const auto& [law, text] : kLaws) {
    if (text == name) return law;
    known += (known.empty() ? "" : ", ") + std::string(text);
  }
  throw Error(concat("unknown law '", name, "'; known are ", known));
}

std::span<const MaterialPreset> material_presets() {
  return kPresets;
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
}

}  // namespace elastogen
