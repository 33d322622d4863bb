// SPDX-License-Identifier: Apache-2.0
// Keys that change a material, for options and regions.

#pragma once

#include "mpm_fem/materials/solid.hpp"

#include <string_view>

namespace elastogen {

/// young, poisson, density and law for any solid. For those that yield also
///
///     yield           metal: stress sigma_Y of a bar [Pa]; snow: pressure p0 [Pa]
///     hardening       metal: H [Pa]; snow: xi [-]
///     friction-angle  sand: of triaxial compression; snow: that of the slope M
///     cohesion        sand: Hencky strain that it bears [-]; snow: beta [-]
///
/// @throws Error on an unknown key, one that the solid does not have, or a value that is no number.
void change_solid(std::string_view key, std::string_view value, Solid& solid);

/// @throws Error as check_material and check_yield.
void check_solid(const Solid& solid);

}  // namespace elastogen
