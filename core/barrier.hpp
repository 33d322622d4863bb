// SPDX-License-Identifier: Apache-2.0
// Contact barrier and smoothed Coulomb friction of one point, as functions of one number (Li et
// al., Incremental Potential Contact, 2020).

#pragma once

#include "core/base.hpp"

#include <cmath>

namespace elastogen {

/// A function of one variable with its first two derivatives.
struct Curve {
  double value = 0, first = 0, second = 0;
};

/// Below it the barrier continues as a parabola. Otherwise a point that an impact has driven to a
/// millionth of the layer would have a stiffness beside which float resolves no other one, and
/// would never come off. Points do not cross a core, because steps are cut before they do.
inline constexpr double kBarrierCut = 1e-3;

/// Share of the layer that cut steps leave to a point at least.
inline constexpr double kLeastDistance = 1e-6;

namespace detail {

/// -(1 - s)^2 ln s.
ELASTOGEN_HD inline Curve log_barrier(double s) {
  const double l = std::log(s), r = 1 - s;
  return {-r * r * l, 2 * r * l - r * r / s, -2 * l + 4 * r / s + r * r / (s * s)};
}

}  // namespace detail

/// b(s) = -(1 - s)^2 ln s for kBarrierCut < s < 1, 0 for s >= 1, and below its Taylor polynomial of
/// second degree about kBarrierCut: C2 and convex.
ELASTOGEN_HD inline Curve barrier(double s) {
  if (s >= 1) return {};
  if (!(s < kBarrierCut)) return detail::log_barrier(s);
  const Curve cut = detail::log_barrier(kBarrierCut);
  const double d = s - kBarrierCut;
  return {cut.value + d * (cut.first + d / 2 * cut.second), cut.first + d * cut.second, cut.second};
}

/// Length f0(y) of a slip y >= 0, as force and stiffness need it: f0, f0'/y (finite at y = 0) and
/// f0''.
struct SmoothedSlip {
  double value, first_over_y, second;
};

///     f0 = -y^3/(3 e^2) + y^2/e + e/3,   f0' = 2 y/e - y^2/e^2   (y < e);      f0 = y beyond.
ELASTOGEN_HD inline SmoothedSlip smoothed_slip(double y, double e) {
  if (y >= e) return {y, 1 / y, 0};
  return {-y * y * y / (3 * e * e) + y * y / e + e / 3, 2 / e - y / (e * e),
          2 / e - 2 * y / (e * e)};
}

/// That of an elastic, ideally plastic bond which gives way at the slip e:
///
///     f0 = y^2/(2 e)   (y < e);      f0 = y - e/2 beyond.
ELASTOGEN_HD inline SmoothedSlip elastic_slip(double y, double e) {
  if (y >= e) return {y - e / 2, 1 / y, 0};
  return {y * y / (2 * e), 1 / e, 1 / e};
}

}  // namespace elastogen
