// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/materials/yield.hpp"

#include "core/error.hpp"

#include <numbers>

namespace elastogen {

void check_yield(const Material& material, const MetalYield& yield) {
  check_material(material);
  ELASTOGEN_CHECK(std::isfinite(yield.stress) && yield.stress > 0,
                  "the yield stress must be positive, got ", yield.stress, " Pa");
  ELASTOGEN_CHECK(std::isfinite(yield.hardening) && yield.hardening >= 0,
                  "the hardening must not be negative, got ", yield.hardening, " Pa");
}

void check_yield(const Material& material, const SandYield& yield) {
  check_material(material);
  ELASTOGEN_CHECK(yield.friction >= 0 && yield.friction < std::numbers::pi / 2,
                  "the friction angle must lie in [0, pi/2), got ", yield.friction, " rad");
  ELASTOGEN_CHECK(std::isfinite(yield.cohesion) && yield.cohesion >= 0,
                  "the cohesion must not be negative, got ", yield.cohesion);
}

void check_yield(const Material& material, const SnowYield& yield, int d) {
  check_material(material);
  ELASTOGEN_CHECK(std::isfinite(yield.slope) && yield.slope > 0,
                  "the slope of the critical state must be positive, got ", yield.slope);
  ELASTOGEN_CHECK(std::isfinite(yield.cohesion) && yield.cohesion >= 0,
                  "the cohesion must not be negative, got ", yield.cohesion);
  ELASTOGEN_CHECK(std::isfinite(yield.hardening) && yield.hardening > 0,
                  "the hardening must be positive, got ", yield.hardening);
  const double bulk = bulk_modulus(material, d);
  ELASTOGEN_CHECK(yield.pressure > 1e-5 * bulk && yield.pressure < 0.45 * bulk,
                  "the yield pressure must lie between ", 1e-5 * bulk, " and ", 0.45 * bulk,
                  " Pa, got ", yield.pressure);
}

}  // namespace elastogen
