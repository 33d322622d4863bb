// SPDX-License-Identifier: Apache-2.0
// All named materials, elastic ones and those that yield, and measures of their yield.

#pragma once

#include "mpm_fem/materials/solid.hpp"

#include <string>
#include <string_view>

namespace elastogen {

struct SolidPreset {
  Solid solid;
  const char* kind;              ///< as in MaterialPreset
  const char* source;            ///< where the numbers come from
  const char* loss_source = "";  ///< where the loss factor comes from
};

/// The preset of that name. @throws Error naming the known ones.
SolidPreset solid_preset(std::string_view name);

/// Behaviour beyond the elastic range: "elastic", "metal", "sand" or "snow".
const char* yield_name(const Yield& yield);

/// Whether a body falls apart into grains: one of sand, or of snow whose strength in tension beta
/// p0 is below 10 kPa.
bool is_granular(const Yield& yield);

/// M = 6 sin/(3 - sin) of a friction angle [rad]: the slope of the critical state of snow.
double critical_slope(double friction);
/// The friction angle of a slope M [rad].
double critical_angle(double slope);

}  // namespace elastogen
