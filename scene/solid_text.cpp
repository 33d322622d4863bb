// SPDX-License-Identifier: Apache-2.0
#include "scene/solid_text.hpp"

#include "core/error.hpp"
#include "io/units.hpp"
#include "mpm_fem/materials/solid_presets.hpp"

namespace elastogen {
namespace {

bool parse_flag(std::string_view text) {
  ELASTOGEN_CHECK(text == "true" || text == "false", "'", text, "' is neither true nor false");
  return text == "true";
}

bool change_yield(std::string_view key, std::string_view value, Yield& yield) {
  // which kind yields decides which keys there are
  auto* metal = std::get_if<MetalYield>(&yield);
  auto* sand = std::get_if<SandYield>(&yield);
  auto* snow = std::get_if<SnowYield>(&yield);
  // strength and hardening
  if (key == "yield" && metal)
    metal->stress = parse_pressure(value);
  else if (key == "yield" && snow)
    snow->pressure = parse_pressure(value);
  else if (key == "hardening" && metal)
    metal->hardening = parse_pressure(value);
  else if (key == "hardening" && snow)
    snow->hardening = parse_number(value);
  // friction and cohesion of grains
  else if (key == "friction-angle" && sand)
    sand->friction = parse_angle(value);
  else if (key == "friction-angle" && snow)
    snow->slope = critical_slope(parse_angle(value));
  else if (key == "cohesion" && sand)
    sand->cohesion = parse_number(value);
  else if (key == "cohesion" && snow)
    snow->cohesion = parse_number(value);
  else if (key == "keeps-volume" && sand)
    sand->keeps_volume = parse_flag(value);
  else
    return false;
  return true;
}

bool is_of_yield(std::string_view key) {
  return key == "yield" || key == "hardening" || key == "friction-angle" || key == "cohesion" ||
         key == "keeps-volume";
}

}  // namespace

void change_solid(std::string_view key, std::string_view value, Solid& solid) {
  Material& m = solid.elastic;
  if (key == "young")
    m.young = parse_pressure(value);
  else if (key == "poisson")
    m.poisson = parse_number(value);
  else if (key == "density")
    m.density = parse_density(value);
  else if (key == "law")
    m.law = law_from_name(value);
  else if (key == "damping")
    m.loss_factor = parse_number(value);
  else if (key == "damping-frequency")
    m.loss_frequency = parse_quantity(value, Quantity::kFrequency);
  else if (!change_yield(key, value, solid.yield))
    throw Error(is_of_yield(key)
                    ? concat("'", m.name, "' is ", yield_name(solid.yield), ": it has no ", key)
                    : concat("'", key, "' is none of young, poisson, density, law, damping"));
}

void check_solid(const Solid& solid) {
  point_law<3>(solid);
}

}  // namespace elastogen
