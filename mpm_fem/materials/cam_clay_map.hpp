// SPDX-License-Identifier: Apache-2.0
// The map of cam_clay.hpp and its hardening.

#pragma once

#include "mpm_fem/materials/cam_clay.hpp"

namespace elastogen {

/// The mean x for which b_i = rho_i + x have product 1, rho free of trace: b is the strain of that
/// shear.
template <int d, class T>
ELASTOGEN_HD inline T mean_of_unit_product(const T rho[3]) {
  if constexpr (d == 2) return square_root(1 + rho[0] * rho[0]);
  const T least = smaller(smaller(rho[0], rho[1]), rho[2]);
  const auto product = [&](T x) {
    const T a = rho[0] + x, b = rho[1] + x, c = rho[2] + x;
    return ValueAndSlope<T>{a * b * c - 1, a * b + b * c + c * a};
  };
  // every factor is at least 1 at the start, right of the root, where the product is convex
  return increasing_root(product, -least, 1 - least, 1 - least);
}

/// The elastic response.
template <bool kTangent, class T, int d>
ELASTOGEN_HD inline Returned<T> snow_inside(const HenckyStrain<T, d>& e, const SnowShear<T>& shear,
                                            T bulk) {
  const ValueAndSlope<T> volume = snow_volume(bulk, e.trace);
  Returned<T> r;
  r.psi = shear.energy + volume.value;
  T sum = 0;
  for (int i = 0; i < d; ++i) {
    r.e[i] = e.e[i];
    r.tau[i] = volume.slope + shear.dev[i];
    sum += 2 * shear.A[i] / d;
  }
  if constexpr (kTangent)
    for (int i = 0; i < d; ++i)
      for (int j = 0; j < d; ++j) {
        // J dp/dJ, and 2 A projected to zero trace from both sides
        r.D(i, j) = bulk + 2 * volume.slope + (i == j ? 2 * shear.A[i] : T(0)) -
                    (2 * shear.A[i] + 2 * shear.A[j] - sum) / d;
      }
  return r;
}

/// Moves a response with |dev tau| > radius to the ellipse: dev tau keeps its direction nu,
/// D = k J^2 1 1^T + radius' nu 1^T + radius/|dev tau| (I - nu nu^T) D_dev.
template <bool kTangent, class T, int d>
ELASTOGEN_HD inline void project_shear(const HenckyStrain<T, d>& e, const SnowShear<T>& shear,
                                       const ValueAndSlope<T>& radius, T mu, T bulk,
                                       Returned<T>& r) {
  const T factor = radius.value / shear.size;
  T nu[3] = {}, rho[3] = {};
  for (int i = 0; i < d; ++i) nu[i] = shear.dev[i] / shear.size, rho[i] = radius.value / mu * nu[i];
  const T x = mean_of_unit_product<d>(rho);
  const ValueAndSlope<T> volume = snow_volume(bulk, e.trace);
  r.psi = mu * d / 2 * (x - 1) + volume.value;
  for (int i = 0; i < d; ++i) {
    r.e[i] = e.trace / d + std::log1p(rho[i] + (x - 1)) / 2;
    r.tau[i] = volume.slope + radius.value * nu[i];
  }
  if constexpr (kTangent) {
    const T volumetric = bulk + 2 * volume.slope;
    for (int j = 0; j < d; ++j) {
      T along = 0;
      for (int i = 0; i < d; ++i) r.D(i, j) -= volumetric, along += nu[i] * r.D(i, j);
      for (int i = 0; i < d; ++i)
        r.D(i, j) = volumetric + radius.slope * nu[i] + factor * (r.D(i, j) - along * nu[i]);
    }
  }
}

template <class T, int d>
template <bool kTangent>
ELASTOGEN_HD Returned<T> CamClay<T, d>::returned(const HenckyStrain<T, d>& e,
                                                 const History& history) const {
  const SnowEllipse<T> y = ellipse(history);
  if (e.trace < y.compressed || e.trace > y.opened) {
    const T tip = e.trace < y.compressed ? y.compressed : y.opened;
    const ValueAndSlope<T> volume = snow_volume(bulk, tip);
    Returned<T> r;
    r.psi = volume.value;
    for (int i = 0; i < d; ++i) r.e[i] = tip / d, r.tau[i] = volume.slope;
    return r;
  }
  const SnowShear<T> shear = snow_shear(e, mu);
  Returned<T> r = snow_inside<kTangent>(e, shear, bulk);
  const ValueAndSlope<T> limit = radius(y, e.trace);
  if (!(shear.size <= limit.value)) project_shear<kTangent>(e, shear, limit, mu, bulk, r);
  return r;
}

template <class T, int d>
ELASTOGEN_HD T CamClay<T, d>::compaction(const HenckyStrain<T, d>& e,
                                         const History& history) const {
  const SnowEllipse<T> y = ellipse(history);
  if (e.trace < y.compressed) return e.trace - y.compressed;
  if (e.trace > y.opened) return e.trace - y.opened;
  const T size = snow_shear(e, mu).size;
  if (!(size > radius(y, e.trace).value)) return 0;
  const T centre = (y.pressure - y.tension) / 2, half = (y.pressure + y.tension) / 2;
  const T p = -snow_volume(bulk, e.trace).slope, across = slope * (p - centre);
  const T q = square_root(T(6 - d) / 2 * (1 + 2 * cohesion)) * size;
  const T left = centre + (p - centre) * slope * half / square_root(across * across + q * q);
  return e.trace - std::log1p(-2 * left / bulk) / 2;
}

/// @throws Error as check_yield.
template <class T, int d = 3>
CamClay<T, d> cam_clay(const Material& material, const SnowYield& yield) {
  check_yield(material, yield, d);
  const double bulk = bulk_modulus(material, d);
  return {T(material.mu()),   T(bulk),
          T(yield.slope),     T(yield.cohesion),
          T(yield.hardening), T(-std::asinh(yield.pressure / bulk - 1e-5) / yield.hardening)};
}

}  // namespace elastogen
