// SPDX-License-Identifier: Apache-2.0
// Parameters of an elastic solid and the named presets.

#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace elastogen {

/// An isotropic law of core/elastic_law.hpp; three are families with a shape parameter.
struct Law {
  enum class Kind : uint8_t {
    kFixedCorotated,
    kNeoHookean,
    kStableNeoHookean,
    kStvk,
    kHencky,
    kOgden,         ///< shape: the exponent
    kMooneyRivlin,  ///< shape: c01/(c10 + c01)
    kGent,          ///< shape: limit of I1 - 3
  };
  Kind kind = Kind::kNeoHookean;
  double shape = 0;

  static const Law kFixedCorotated, kNeoHookean, kStableNeoHookean, kStvk, kHencky;
  static constexpr Law ogden(double exponent) { return {Kind::kOgden, exponent}; }
  static constexpr Law mooney_rivlin(double share) { return {Kind::kMooneyRivlin, share}; }
  static constexpr Law gent(double limit) { return {Kind::kGent, limit}; }

  friend bool operator==(const Law&, const Law&) = default;
};

inline constexpr Law Law::kFixedCorotated{Kind::kFixedCorotated};
inline constexpr Law Law::kNeoHookean{Kind::kNeoHookean};
inline constexpr Law Law::kStableNeoHookean{Kind::kStableNeoHookean};
inline constexpr Law Law::kStvk{Kind::kStvk};
inline constexpr Law Law::kHencky{Kind::kHencky};

/// Name of a law as the command and the files spell it, e.g. "neo-hookean", "ogden=4".
std::string law_name(const Law& law);

/// The law of that name. @throws Error naming the known laws, or the range of a shape parameter:
/// Ogden -20 ... 20, Mooney-Rivlin 0 ... 1, Gent 0.1 ... 1e6.
Law law_from_name(std::string_view name);

/// Names as law_from_name accepts them, "ogden=NUMBER" for a family.
std::vector<std::string> law_names();

/// An elastic solid. Lame constants follow from Young's modulus and Poisson's ratio.
struct Material {
  std::string name = "rubber";
  Law law = Law::kNeoHookean;
  double young = 1e6;     ///< E [Pa], > 0
  double poisson = 0.45;  ///< nu [-], 0 <= nu < 0.5
  double density = 1100;  ///< rho [kg/m^3], > 0

  // damping (core/viscous.hpp)
  std::optional<double> loss_factor = {};  ///< tan(delta) at loss_frequency; none: no damping
  double loss_frequency = 10;              ///< [Hz], > 0
  double usual_loss = 0;  ///< loss factor of the preset, for scenes that choose none

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

  // damping, for time schemes that have hardly any of their own
  double loss_factor = 0;        ///< tan(delta) at loss_frequency; 0: none
  double loss_frequency = 10;    ///< [Hz]
  const char* loss_source = "";  ///< where these come from
};

std::span<const MaterialPreset> material_presets();

/// The elastic parts of the presets that yield; mpm_fem/materials/solid_presets.hpp has the rest.
std::span<const MaterialPreset> yielding_presets();

/// The elastic preset of that name. @throws Error naming the known ones.
const MaterialPreset& material_preset(std::string_view name);

/// @throws Error unless E, rho are positive and finite, 0 <= nu < 0.5, and the shape parameter is
/// in the range of law_from_name.
void check_material(const Material& material);

/// Young's modulus of the contact layer of a material [Pa]: its own, or what stops the outermost
/// voxels at a speed v [m/s] within the layer, where that is more,
///
///     max(E, 8 rho v^2):   A kappa b(s) = rho A h v^2 / 2 at b(s) = 1, s = 0.24
///
/// (core/point_contact.hpp). A body that lands faster than elastic waves run in it would else be
/// driven through the layer.
double contact_young(const Material& material, double v);

}  // namespace elastogen
