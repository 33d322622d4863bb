// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/materials/solid_presets.hpp"

#include "core/error.hpp"

#include <numbers>
#include <utility>

namespace elastogen {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

const std::pair<std::string_view, Yield> kYields[] = {
    {"sand", SandYield{.friction = 35 * kDegree}},
    {"wet-sand", SandYield{.friction = 35 * kDegree, .cohesion = 1e-3}},
    {"snow",
     SnowYield{
         .slope = critical_slope(45 * kDegree), .cohesion = 0.5, .hardening = 1, .pressure = 5e3}},
    {"packed-snow",
     SnowYield{
         .slope = critical_slope(45 * kDegree), .cohesion = 1, .hardening = 1, .pressure = 3e4}},
    {"clay", MetalYield{.stress = 6.1e3}},
    {"aluminium", MetalYield{.stress = 2.76e8, .hardening = 5e8}},
    {"copper", MetalYield{.stress = 6e7, .hardening = 6e8}},
    {"lead", MetalYield{.stress = 8e6, .hardening = 2.5e7}},
    {"steel", MetalYield{.stress = 2.5e8, .hardening = 1e9}},
};

}  // namespace

SolidPreset solid_preset(std::string_view name) {
  std::string known;
  for (const MaterialPreset& preset : material_presets()) {
    if (preset.material.name == name) {
      Material material = preset.material;
      material.usual_loss = preset.loss_factor;
      material.loss_frequency = preset.loss_frequency;
      return {{std::move(material), {}}, preset.kind, preset.source, preset.loss_source};
    }
    known += (known.empty() ? "" : ", ") + preset.material.name;
  }
  for (const MaterialPreset& preset : yielding_presets()) {
    known += ", " + preset.material.name;
    if (preset.material.name != name) continue;
    for (const auto& [yielding, yield] : kYields)
      if (yielding == name) return {{preset.material, yield}, preset.kind, preset.source};
  }
  throw Error(concat("unknown material '", name, "'; known are ", known));
}

const char* yield_name(const Yield& yield) {
  constexpr const char* kNames[] = {"elastic", "metal", "sand", "snow"};
  return kNames[yield.index()];
}

bool is_granular(const Yield& yield) {
  constexpr double kStrength = 1e4;  // [Pa]
  const auto* snow = std::get_if<SnowYield>(&yield);
  return std::holds_alternative<SandYield>(yield) ||
         (snow && snow->cohesion * snow->pressure < kStrength);
}

double critical_slope(double friction) {
  return 6 * std::sin(friction) / (3 - std::sin(friction));
}

double critical_angle(double slope) {
  return std::asin(3 * slope / (6 + slope));
}

}  // namespace elastogen
