// SPDX-License-Identifier: Apache-2.0
// Random strains, differences, and every return map with the parameters that the tests give it.

#pragma once

#include "mpm_fem/materials/associative_neo_von_mises.hpp"
#include "mpm_fem/materials/cam_clay_map.hpp"
#include "mpm_fem/materials/drucker_prager.hpp"
#include "mpm_fem/materials/von_mises.hpp"
#include "tests/support/matrices.hpp"

namespace elastogen::test {

/// E = 1 Pa, nu = 0.3; metal that yields at 0.02 Pa, sand with cohesion, snow with tips at strains
/// of about 0.03.
inline Material plastic_solid() {
  Material m;
  m.young = 1, m.poisson = 0.3;
  return m;
}
inline constexpr MetalYield kMetal = {.stress = 0.02, .hardening = 0.1};
inline constexpr SandYield kSand = {.friction = 0.5, .cohesion = 0.01};
inline constexpr SnowYield kSnow = {
    .slope = 1.2, .cohesion = 0.5, .hardening = 1, .pressure = 0.05};

/// visit(law) with all laws over T in d dimensions.
template <class T, int d, class Visit>
void for_each_map(const Visit& visit) {
  visit("von Mises", von_mises<T, d>(plastic_solid(), kMetal));
  visit("Drucker-Prager", drucker_prager<T, d>(plastic_solid(), kSand));
  visit("Cam-Clay", cam_clay<T, d>(plastic_solid(), kSnow));
  visit("neo-Hookean von Mises", neo_von_mises<T, d>(plastic_solid(), kMetal));
  visit("without hardening", neo_von_mises<T, d>(plastic_solid(), {.stress = 0.02}));
  if constexpr (d == 3) {
    using Law = AssociativeNeoVonMises<T>;
    visit("associative", Law{neo_von_mises<T>(plastic_solid(), kMetal)});
    visit("associative without hardening",
          Law{neo_von_mises<T>(plastic_solid(), {.stress = 0.02})});
  }
}

/// A strain with entries within `size` of 0.
template <int d>
HenckyStrain<double, d> random_strain(double size, Random& random) {
  std::uniform_real_distribution<double> in(-size, size);
  const double e[3] = {in(random), in(random), d == 3 ? in(random) : 0};
  return split_strain<d>(e);
}

/// The strain with that trace and size, with the direction of another.
template <int d>
HenckyStrain<double, d> strain_along(const HenckyStrain<double, d>& other, double trace,
                                     double size) {
  double e[3] = {};
  set_strain<d>(trace, size, other.n, e);
  return split_strain<d>(e);
}

template <int d, class Law>
Returned<double> returned(const Law& law, const HenckyStrain<double, d>& e,
                          const typename Law::History& history = {}) {
  return law.template returned<true>(e, history);
}

inline double largest(const Mat3<double>& A) {
  double most = 0;
  for (const double a : A.m) most = std::fmax(most, std::abs(a));
  return most;
}

/// The largest difference of D from central differences of tau, over the largest entry of D or mu.
template <int d, class Law>
double tangent_error(const Law& law, const HenckyStrain<double, d>& e,
                     const typename Law::History& history = {}, double step = 1e-7) {
  const Mat3<double> D = returned(law, e, history).D;
  double most = 0;
  for (int j = 0; j < d; ++j) {
    HenckyStrain<double, d> ends[2] = {e, e};
    for (int end = 0; end < 2; ++end) {
      ends[end].e[j] += end ? -step : step;
      ends[end] = split_strain<d>(ends[end].e);
    }
    const Returned<double> above = returned(law, ends[0], history),
                           below = returned(law, ends[1], history);
    for (int i = 0; i < d; ++i)
      most = std::fmax(most, std::abs((above.tau[i] - below.tau[i]) / (2 * step) - D(i, j)));
  }
  return most / std::fmax(largest(D), plastic_solid().mu());
}

/// The largest difference of tau from central differences of psi [Pa].
template <int d, class Law>
double gradient_error(const Law& law, const HenckyStrain<double, d>& e,
                      const typename Law::History& history = {}, double step = 1e-7) {
  const Returned<double> r = returned(law, e, history);
  double most = 0;
  for (int j = 0; j < d; ++j) {
    double psi[2];
    for (int end = 0; end < 2; ++end) {
      double moved[3] = {e.e[0], e.e[1], e.e[2]};
      moved[j] += end ? -step : step;
      psi[end] = returned(law, split_strain<d>(moved), history).psi;
    }
    most = std::fmax(most, std::abs((psi[0] - psi[1]) / (2 * step) - r.tau[j]));
  }
  return most;
}

/// |dev| and trace of the first d principal values.
template <int d>
HenckyStrain<double, d> parts(const double tau[3]) {
  return split_strain<d>(tau);
}

template <int d>
double distance(const double a[3], const double b[3]) {
  double square = 0;
  for (int i = 0; i < d; ++i) square += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(square);
}

}  // namespace elastogen::test
