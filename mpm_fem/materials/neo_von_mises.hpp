// SPDX-License-Identifier: Apache-2.0
// Metal: neo-Hookean elasticity mu/2 (tr b - d) - mu ln J + lambda/2 ln^2 J with von Mises' bound
// on |dev tau| and linear hardening. As in PlasticityNet (Li et al. 2022), the strain returns along
// its deviator, with t and n fixed, to the size s with
//
//     mu exp(2t/d) |dev exp(2 s n)| = radius + H (flow + a - s),
//
// The left side grows from 0 with s, so there is one s. For d = 2 this is the associated flow and
// psi a potential; for d = 3 the tangent is not symmetric, by about a hundredth.

#pragma once

#include "mpm_fem/materials/metal.hpp"
#include "mpm_fem/materials/yield.hpp"

namespace elastogen {

/// Stress of a strain: A = mu b, dev and mean of A - mu with |dev|, and the energy density.
template <class T>
struct NeoHookeanStress {
  T A[3] = {}, dev[3] = {}, size = 0, mean = 0, energy = 0;
};

/// The stress of the strain (trace/d) 1 + x, x free of trace.
template <int d, class T>
ELASTOGEN_HD inline NeoHookeanStress<T> neo_hookean_stress(T trace, const T x[3], T mu, T lambda) {
  const T growth = std::expm1(2 * trace / d), scale = mu * (1 + growth);  // J^(2/d) - 1
  NeoHookeanStress<T> r;
  T mean = 0;
  for (int i = 0; i < d; ++i) r.dev[i] = std::expm1(2 * x[i]), mean += r.dev[i] / d;
  for (int i = 0; i < d; ++i) {
    r.A[i] = scale * (1 + r.dev[i]);
    r.dev[i] = scale * (r.dev[i] - mean), r.size += r.dev[i] * r.dev[i];
  }
  r.size = square_root(r.size);
  r.mean = scale * mean + mu * growth;
  r.energy = r.mean * d / 2 - mu * trace + lambda / 2 * trace * trace;
  return r;
}

template <class T, int d = 3>
struct NeoVonMises {
  using Real = T;
  using History = FlowHistory<T>;
  T mu, lambda;         ///< [Pa]
  T radius, hardening;  ///< |dev tau| <= radius + hardening flow [Pa]

  /// The stress of the strain whose deviator is s n.
  ELASTOGEN_HD NeoHookeanStress<T> stress(const HenckyStrain<T, d>& e, T s) const {
    T x[3] = {};
    set_strain<d>(T(0), s, e.n, x);
    return neo_hookean_stress<d>(e.trace, x, mu, lambda);
  }

  /// The size s of the deviator on the surface whose radius is `limit` before the flow a - s.
  ELASTOGEN_HD T size_after(const HenckyStrain<T, d>& e, T limit) const {
    const T scale = exponential(T(2 * e.trace / d)), root2 = square_root(T(2));
    if (d == 2 && hardening == 0)
      return smaller(e.size, T(std::asinh(limit / (root2 * mu * scale)) / root2));
    const auto excess = [&](T s) {
      T slope = 0;
      const NeoHookeanStress<T> b = stress(e, s);
      for (int i = 0; i < d; ++i) slope += 2 * b.A[i] * e.n[i] * b.dev[i];
      return ValueAndSlope<T>{b.size - limit - hardening * (e.size - s),
                              (b.size > 0 ? slope / b.size : 2 * mu * scale) + hardening};
    };
    return increasing_root(excess, T(0), e.size, smaller(e.size, T(limit / (2 * mu * scale))));
  }

  /// D = dtau/de with s = size_after. With g the gradient of |dev tau| in the strain after the map,
  /// and Q the derivative of that strain at fixed s, ds = (H n - Q g).de/(g.n + H).
  ELASTOGEN_HD void set_plastic_tangent(const HenckyStrain<T, d>& e, T s,
                                        const NeoHookeanStress<T>& b, Returned<T>& r) const {
    T g[3], ds[3] = {}, along = hardening;
    Mat3<T> Q = {};
    for (int i = 0; i < d; ++i) {
      g[i] = 2 * b.A[i] * (b.dev[i] / b.size), along += g[i] * e.n[i];
      for (int j = 0; j < d; ++j)
        Q(i, j) = T(1) / d + s / e.size * ((i == j) - T(1) / d - e.n[i] * e.n[j]);
    }
    for (int i = 0; i < d; ++i) {
      ds[i] = hardening * e.n[i];
      for (int j = 0; j < d; ++j) ds[i] -= Q(i, j) * g[j];
      ds[i] /= along;
    }
    for (int i = 0; i < d; ++i)
      for (int j = 0; j < d; ++j) r.D(i, j) = lambda + 2 * b.A[i] * (Q(i, j) + e.n[i] * ds[j]);
  }

  template <bool kTangent>
  ELASTOGEN_HD Returned<T> returned(const HenckyStrain<T, d>& e, const History& history) const {
    const T limit = radius + hardening * history.flow;
    NeoHookeanStress<T> b = stress(e, e.size);
    const bool flows = !(b.size <= limit) && e.size > 0;
    const T s = flows ? size_after(e, limit) : e.size, flow = e.size - s;
    Returned<T> r;
    for (int i = 0; i < d; ++i) r.e[i] = e.e[i];
    if (flows) {
      set_strain<d>(e.trace, s, e.n, r.e);
      b = stress(e, s);
    }
    r.psi = b.energy + (limit + hardening / 2 * flow) * flow;
    for (int i = 0; i < d; ++i) r.tau[i] = b.mean + lambda * e.trace + b.dev[i];
    if constexpr (kTangent) {
      for (int i = 0; i < d; ++i)
        for (int j = 0; j < d; ++j) r.D(i, j) = lambda + (i == j ? 2 * b.A[i] : T(0));
      if (flows) set_plastic_tangent(e, s, b, r);
    }
    return r;
  }

  /// In the plane psi is a potential of tau.
  template <bool kTangent>
  ELASTOGEN_HD auto response(const T s[3], const History& history) const {
    const Returned<T> r = returned<kTangent>(hencky_strain<d>(s), history);
    if constexpr (d == 2)
      return symmetric_in_stretches(s, r);
    else
      return in_stretches(s, r);
  }

  ELASTOGEN_HD Returned<T> commit(const HenckyStrain<T, d>& e, History& history) const {
    return commit_flow(*this, e, history);
  }
  ELASTOGEN_HD void commit(T s[3], History& history) const {
    commit_stretches<d>(*this, s, history);
  }
};

/// @throws Error as check_yield.
template <class T, int d = 3>
NeoVonMises<T, d> neo_von_mises(const Material& material, const MetalYield& yield) {
  check_yield(material, yield);
  const double norm = yield_norm(d);
  return {T(material.mu()), T(material.lambda()), T(yield.stress / norm),
          T(yield.hardening / (norm * norm))};
}

}  // namespace elastogen
