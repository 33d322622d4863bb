// SPDX-License-Identifier: Apache-2.0
#include "io/scene_material_keys.hpp"

#include "core/material.hpp"
#include "io/scene_load_keys.hpp"

#include <utility>

namespace elastogen {
namespace {

using T = SceneType;
using Q = Quantity;
using Keys = std::vector<SceneKey>;

const SceneRange kAboveZero = {.least = 0, .above = true};
const SceneRange kFromZero = {.least = 0};

std::vector<std::string> preset_names() {
  std::vector<std::string> names;
  for (const MaterialPreset& preset : material_presets()) names.push_back(preset.material.name);
  for (const MaterialPreset& preset : yielding_presets()) names.push_back(preset.material.name);
  return names;
}

/// The keys that change when a material yields.
Keys yield_keys(const std::string& table) {
  const bool main = table == "material";
  const std::string same = "that of the preset";
  return {
      {table, "yield", T::kNumber, same, main ? "--yield" : "",
       "of metal and clay the stress at which a bar flows, of snow its pressure p0", Q::kPressure,
       kAboveZero},
      {table, "hardening", T::kNumber, same, main ? "--hardening" : "",
       "of metal stress over plastic strain of a bar, of snow the factor xi", Q::kPressure,
       kFromZero},
      {table,
       "friction_angle",
       T::kNumber,
       same,
       main ? "--friction-angle" : "",
       "of sand and snow",
       Q::kAngle,
       {.least = 0, .below = true}},
      {table, "cohesion", T::kNumber, same, main ? "--cohesion" : "",
       "of sand the strain that it bears, of snow tensile strength over p0", Q::kNumber, kFromZero},
      {table, "keeps_volume", T::kFlag, same, main ? "--keeps-volume" : "",
       "of sand: true: what opens has to close before it bears again"},
  };
}

/// The keys of damping.
Keys damping_keys(const std::string& table) {
  const bool main = table == "material";
  return {
      {table,
       "damping",
       T::kNumber,
       "that of the preset; none with euler and bdf2",
       main ? "--damping" : "",
       "loss factor, tan(delta) at damping_frequency",
       Q::kNumber,
       {.least = 0, .most = 10}},
      {table, "damping_frequency", T::kNumber, "that of the preset",
       main ? "--damping-frequency" : "", "frequency of the loss factor", Q::kFrequency,
       kAboveZero},
  };
}

/// The keys that choose and change a material.
Keys material_keys(const std::string& table) {
  // [material] has options of the command, a region has none
  const bool main = table == "material";
  const std::string same = "that of the preset";
  return {
      // what the material is
      {table,
       "preset",
       T::kText,
       main ? "rubber" : "",
       main ? "--material" : "",
       main ? "a material by name" : "a material by name; without it, the preset of [material]",
       Q::kNumber,
       {},
       preset_names()},
      {table,
       "law",
       T::kText,
       same,
       main ? "--law" : "",
       "energy density",
       Q::kNumber,
       {},
       law_names()},
      // its numbers in place of the preset's
      {table, "young", T::kNumber, same, main ? "--young" : "", "Young's modulus", Q::kPressure,
       kAboveZero},
      {table,
       "poisson",
       T::kNumber,
       same,
       main ? "--poisson" : "",
       "Poisson's ratio",
       Q::kNumber,
       {.least = 0, .most = 0.5, .below = true}},
      {table, "density", T::kNumber, same, main ? "--density" : "", "mass over volume", Q::kDensity,
       kAboveZero},
  };
}

}  // namespace

std::vector<SceneKey> main_material_keys() {
  Keys keys = material_keys("material");
  for (SceneKey& key : damping_keys("material")) keys.push_back(std::move(key));
  for (SceneKey& key : yield_keys("material")) keys.push_back(std::move(key));
  return keys;
}

std::vector<SceneKey> region_keys() {
  Keys keys = selection_keys("region");
  for (SceneKey& key : material_keys("region")) keys.push_back(std::move(key));
  for (SceneKey& key : damping_keys("region")) keys.push_back(std::move(key));
  for (SceneKey& key : yield_keys("region")) keys.push_back(std::move(key));
  return keys;
}

}  // namespace elastogen
