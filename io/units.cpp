// SPDX-License-Identifier: Apache-2.0
#include "io/units.hpp"

#include "io/byte_reader.hpp"

#include <numbers>
#include <vector>

namespace elastogen {
namespace {

struct Unit {
  std::string_view name;
  double factor;  ///< SI units in one unit
};

constexpr double kPound = 0.45359237, kInch = 0.0254, kStandardGravity = 9.80665;
constexpr double kDegree = std::numbers::pi / 180;

/// Known units of a quantity, the SI unit first.
const std::vector<Unit>& units_of(Quantity quantity) {
  // one list for each Quantity, in the order of its enumerators
  static const std::vector<Unit> units[] = {
      {},
      {{"m", 1},
       {"nm", 1e-9},
       {"um", 1e-6},
       {"mm", 1e-3},
       {"cm", 1e-2},
       {"km", 1e3},
       {"in", kInch},
       {"ft", 12 * kInch}},
      {{"Pa", 1},
       {"kPa", 1e3},
       {"MPa", 1e6},
       {"GPa", 1e9},
       {"bar", 1e5},
       {"psi", kPound * kStandardGravity / (kInch * kInch)}},
      {{"kg/m3", 1},
       {"kg/m^3", 1},
       {"g/cm3", 1e3},
       {"g/cm^3", 1e3},
       {"g/cc", 1e3},
       {"kg/l", 1e3},
       {"t/m3", 1e3}},
      {{"s", 1}, {"us", 1e-6}, {"ms", 1e-3}, {"min", 60}, {"h", 3600}},
      {{"m/s", 1}, {"mm/s", 1e-3}, {"cm/s", 1e-2}, {"km/h", 1 / 3.6}},
      {{"m/s2", 1}, {"m/s^2", 1}, {"cm/s2", 1e-2}, {"cm/s^2", 1e-2}, {"g0", kStandardGravity}},
      {{"rad", 1}, {"deg", kDegree}},
      {{"rad/s", 1}, {"deg/s", kDegree}, {"rpm", std::numbers::pi / 30}},
      {{"N", 1}, {"mN", 1e-3}, {"kN", 1e3}, {"MN", 1e6}, {"lbf", kPound * kStandardGravity}},
      {{"Hz", 1}, {"kHz", 1e3}},
      {{"B", 1},
       {"kB", 1e3},
       {"MB", 1e6},
       {"GB", 1e9},
       {"TB", 1e12},
       {"KiB", 1024.},
       {"MiB", 1024. * 1024},
       {"GiB", 1024. * 1024 * 1024},
       {"TiB", 1024. * 1024 * 1024 * 1024}},
  };
  return units[int(quantity)];
}

double factor_of(std::string_view name, std::string_view text, Quantity quantity) {
  if (name.empty()) return 1;
  std::string known;
  for (const Unit& unit : units_of(quantity)) {
    if (unit.name == name) return unit.factor;
    known += concat(known.empty() ? "" : ", ", unit.name);
  }
  ELASTOGEN_CHECK(!known.empty(), '"', text, "\": a number without a unit is expected here");
  throw Error(concat('"', text, "\": \"", name, "\" is not a unit known here; known are ", known));
}

/// Cuts a finite number off the front; `text` is the whole text, for the message.
double take_number(std::string_view& rest, std::string_view text) {
  rest = trimmed(rest);
  if (rest.starts_with('+')) rest.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), value);
  ELASTOGEN_CHECK(error == std::errc() && std::isfinite(value), '"', text,
                  "\": a finite number is expected at \"", rest, '"');
  rest.remove_prefix(size_t(end - rest.data()));
  return value;
}

}  // namespace

double parse_quantity(std::string_view text, Quantity quantity) {
  std::string_view rest = text;
  const double value = take_number(rest, text) * factor_of(trimmed(rest), text, quantity);
  ELASTOGEN_CHECK(std::isfinite(value), '"', text, "\": is not finite in SI units");
  return value;
}

double parse_length(std::string_view text) {
  return parse_quantity(text, Quantity::kLength);
}
double parse_pressure(std::string_view text) {
  return parse_quantity(text, Quantity::kPressure);
}
double parse_density(std::string_view text) {
  return parse_quantity(text, Quantity::kDensity);
}
double parse_time(std::string_view text) {
  return parse_quantity(text, Quantity::kTime);
}
double parse_speed(std::string_view text) {
  return parse_quantity(text, Quantity::kSpeed);
}
double parse_angle(std::string_view text) {
  return parse_quantity(text, Quantity::kAngle);
}
double parse_spin(std::string_view text) {
  return parse_quantity(text, Quantity::kSpin);
}
double parse_number(std::string_view text) {
  return parse_quantity(text, Quantity::kNumber);
}

int64_t parse_memory(std::string_view text) {
  const double bytes = parse_quantity(text, Quantity::kMemory);
  ELASTOGEN_CHECK(bytes >= 0 && bytes < 0x1p63, '"', text, "\": is no amount of memory");
  return int64_t(bytes);
}

Vec3 parse_vec3(std::string_view text, Quantity quantity) {
  Vec3 v = {};
  std::string_view rest = text;
  for (int d = 0; d < 3; ++d) {
    v[d] = take_number(rest, text);
    rest = trimmed(rest);
    if (d == 2) break;
    ELASTOGEN_CHECK(rest.starts_with(','), '"', text,
                    "\": three numbers between commas are expected, like 0,-9.81,0");
    rest.remove_prefix(1);
  }
  const double factor = factor_of(rest, text, quantity);
  for (double& x : v) {
    x *= factor;
    ELASTOGEN_CHECK(std::isfinite(x), '"', text, "\": is not finite in SI units");
  }
  return v;
}

}  // namespace elastogen
