// SPDX-License-Identifier: Apache-2.0
// Parameters of an elastic solid and the named presets.

#pragma once

#include <span>
#include <string>
#include <string_view>

namespace elastogen {

/// The isotropic laws of core/elastic_law.hpp.
enum class Law { kFixedCorotated, kNeoHookean, kStableNeoHookean, kStvk, kHencky };

/// Name of a law as the command and the files spell it, e.g. "neo-hookean".
std::string_view law_name(Law law);

/// The law of that name. @throws Error naming the known laws.
Law law_from_name(std::string_view name);

/// An elastic solid. Lame constants follow from Young's modulus and Poisson's ratio.
struct Material {
  std::string name = "rubber";
  Law law = Law::kNeoHookean;
  double young = 1e6;     ///< E [Pa], > 0
  double poisson = 0.45;  ///< nu [-], 0 <= nu < 0.5
  double density = 1100;  ///< rho [kg/m^3], > 0

  double mu() const { return young / (2 * (1 + poisson)); }  ///< shear modulus [Pa]
  double lambda() const {                                    ///< [Pa]
    return young * poisson / ((1 + poisson) * (1 - 2 * poisson));
  }
};

/// A preset with the origin of its numbers.
struct MaterialPreset {
  Material material;
  const char* kind;    ///< "measured", "literature" or "look"
  const char* source;  ///< where the numbers come from
};

std::span<const MaterialPreset> material_presets();

/// The preset of that name. @throws Error naming the known ones.
const MaterialPreset& material_preset(std::string_view name);

/// @throws Error unless E, rho are positive and finite and 0 <= nu < 0.5.
void check_material(const Material& material);

}  // namespace elastogen
