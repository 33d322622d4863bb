// SPDX-License-Identifier: Apache-2.0
// Numbers with units, "3 GPa" or "30cm", converted to SI. A bare number is in SI units.

#pragma once

#include "core/base.hpp"

#include <string_view>

namespace elastogen {

enum class Quantity {
  kNumber,        ///< no unit
  kLength,        ///< m: nm um mm cm m km in ft
  kPressure,      ///< Pa: Pa kPa MPa GPa bar psi
  kDensity,       ///< kg/m3: kg/m3 g/cm3 g/cc kg/l t/m3 (also kg/m^3, g/cm^3)
  kTime,          ///< s: us ms s min h
  kSpeed,         ///< m/s: mm/s cm/s m/s km/h
  kAcceleration,  ///< m/s2: m/s2 m/s^2 cm/s2 cm/s^2 g0
  kAngle,         ///< rad: rad deg
  kSpin,          ///< rad/s: rad/s deg/s rpm
  kForce,         ///< N: N mN kN MN lbf
  kFrequency,     ///< Hz: Hz kHz
  kMemory,        ///< bytes: B kB MB GB TB KiB MiB GiB TiB
};

/// A finite number followed by nothing or by a unit of the quantity; blanks may stand around
/// both. Independent of the locale.
/// @throws Error (usage) naming the text; for an unknown unit also the units that are known.
double parse_quantity(std::string_view text, Quantity quantity);

/// parse_quantity for one quantity each. [m], [Pa], [kg/m^3], [s], [m/s], [rad], [rad/s]
double parse_length(std::string_view text);
double parse_pressure(std::string_view text);
double parse_density(std::string_view text);
double parse_time(std::string_view text);
double parse_speed(std::string_view text);
double parse_angle(std::string_view text);
double parse_spin(std::string_view text);

/// Bytes, rounded down. @throws Error (usage) also where negative or above 2^63 - 1.
int64_t parse_memory(std::string_view text);

/// A number without a unit.
double parse_number(std::string_view text);

/// Three numbers between commas, "0,-9.81,0"; one unit after the last holds for all three.
Vec3 parse_vec3(std::string_view text, Quantity quantity = Quantity::kNumber);

}  // namespace elastogen
