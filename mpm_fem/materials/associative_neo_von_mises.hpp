// SPDX-License-Identifier: Apache-2.0
// NeoVonMises in three dimensions with the associated flow: along dev tau, which for d = 3 is not
// along dev e. It has a potential, the variational update of Ortiz and Stainier 1999,
//
//     psi(e) = min over delta free of trace of  W(e - delta) + radius |delta| + H/2 |delta|^2,
//
// convex in e; its gradient is the stress after the flow and its Hessian D is symmetric.

#pragma once

#include "mpm_fem/materials/neo_von_mises.hpp"

namespace elastogen {

template <class T>
struct AssociativeNeoVonMises {
  using Real = T;
  using History = FlowHistory<T>;
  NeoVonMises<T, 3> line;  ///< the metal with the map along dev e, which gives the first guess

  /// The function that is minimised, with derivatives along u = delta/|delta| and v across it: the
  /// kink at delta = 0 then only adds to H[1].
  struct Objective {
    T value, gradient[2], H[3];  ///< H: uu, vv, uv
    NeoHookeanStress<T> b;
    T u[3], v[3], x[3];  ///< x: the deviator of e - delta
  };
  ELASTOGEN_HD Objective objective(const HenckyStrain<T, 3>& e, T limit, const T delta[3]) const {
    Objective o;
    const T flow = square_root(delta[0] * delta[0] + delta[1] * delta[1] + delta[2] * delta[2]);
    const T h = line.hardening, root3 = square_root(T(3));
    for (int i = 0; i < 3; ++i) o.u[i] = delta[i] / flow, o.x[i] = e.size * e.n[i] - delta[i];
    for (int i = 0; i < 3; ++i) o.v[i] = (o.u[(i + 2) % 3] - o.u[(i + 1) % 3]) / root3;
    o.b = neo_hookean_stress<3>(e.trace, o.x, line.mu, line.lambda);
    o.value = o.b.energy + (limit + h / 2 * flow) * flow;
    o.gradient[0] = limit + h * flow, o.gradient[1] = 0;
    o.H[0] = h, o.H[1] = limit / flow + h, o.H[2] = 0;
    for (int i = 0; i < 3; ++i) {
      o.gradient[0] -= o.b.dev[i] * o.u[i], o.gradient[1] -= o.b.dev[i] * o.v[i];
      o.H[0] += 2 * o.b.A[i] * o.u[i] * o.u[i], o.H[1] += 2 * o.b.A[i] * o.v[i] * o.v[i];
      o.H[2] += 2 * o.b.A[i] * o.u[i] * o.v[i];
    }
    return o;
  }

  /// H^-1 r of a positive definite H, whose determinant may be beyond the range of T.
  ELASTOGEN_HD static void solve(const T H[3], const T r[2], T x[2]) {
    constexpr T kEps = std::numeric_limits<T>::epsilon();
    const int p = H[0] > H[1] ? 0 : 1, q = 1 - p;
    const T ratio = H[2] / H[p], rest = H[q] - ratio * H[2];
    x[q] = (r[q] - ratio * r[p]) / larger(rest, T(kEps * H[q]));
    x[p] = (r[p] - H[2] * x[q]) / H[p];
  }

  /// Newton's method from a flow until strains differ by rounding. A step is halved while psi rises
  /// steeply at its end, which for a convex psi means that it went too far, or if it passes the
  /// kink.
  ELASTOGEN_HD Objective minimum(const HenckyStrain<T, 3>& e, T limit, T delta[3]) const {
    constexpr int kMost = 30, kHalves = 20;
    constexpr T kRounding = 8 * std::numeric_limits<T>::epsilon();
    Objective o = objective(e, limit, delta);
    for (int k = 0; k < kMost; ++k) {
      // Newton's step in u and v
      T step[2];
      solve(o.H, o.gradient, step);
      if (!(absolute(step[0]) + absolute(step[1]) > kRounding * e.size)) break;
      const Objective start = o;
      T before[3] = {delta[0], delta[1], delta[2]};
      // halved until it is short enough
      const T steepest = (o.gradient[0] * step[0] + o.gradient[1] * step[1]) / 2;
      for (int half = 0; half < kHalves; ++half) {
        T ahead = 0, rise = 0;
        for (int i = 0; i < 3; ++i)
          delta[i] = before[i] - (step[0] * start.u[i] + step[1] * start.v[i]) / T(1 << half);
        o = objective(e, limit, delta);
        for (int i = 0; i < 3; ++i) {
          ahead += o.u[i] * start.u[i];
          rise -= (o.gradient[0] * o.u[i] + o.gradient[1] * o.v[i]) *
                  (step[0] * start.u[i] + step[1] * start.v[i]);
        }
        if (ahead > 0 && rise <= steepest) break;
      }
    }
    return o;
  }

  /// D = W'' - W'' B H^-1 B^T W'' with B = (u, v), W'' = diag(2 A) + lambda 1 1^T.
  ELASTOGEN_HD void set_tangent(const Objective& o, Mat3<T>& D) const {
    for (int i = 0; i < 3; ++i) {
      const T stiffness = 2 * o.b.A[i], row[2] = {stiffness * o.u[i], stiffness * o.v[i]};
      T y[2];
      solve(o.H, row, y);
      for (int j = 0; j < 3; ++j)
        D(i, j) = line.lambda + (i == j ? stiffness : T(0)) -
                  2 * o.b.A[j] * (o.u[j] * y[0] + o.v[j] * y[1]);
    }
  }

  template <bool kTangent>
  ELASTOGEN_HD Returned<T> returned(const HenckyStrain<T, 3>& e, const History& history) const {
    constexpr T kEps = std::numeric_limits<T>::epsilon();
    const T limit = line.radius + line.hardening * history.flow;
    if (line.stress(e, e.size).size <= limit || !(e.size > 0))
      return line.template returned<kTangent>(e, history);
    // first guess: as much flow as in the map along dev e, but along dev tau
    const T size = smaller(line.size_after(e, limit), T((1 - kEps) * e.size));
    const NeoHookeanStress<T> b = line.stress(e, size);
    T delta[3];
    for (int i = 0; i < 3; ++i) delta[i] = (e.size - size) * (b.dev[i] / b.size);
    const Objective o = minimum(e, limit, delta);
    Returned<T> r;
    r.psi = o.value;
    for (int i = 0; i < 3; ++i) {
      r.e[i] = e.trace / 3 + o.x[i];
      r.tau[i] = o.b.mean + line.lambda * e.trace + o.b.dev[i];
    }
    if constexpr (kTangent) set_tangent(o, r.D);
    return r;
  }

  template <bool kTangent>
  ELASTOGEN_HD Response<T> response(const T s[3], const History& history) const {
    return symmetric_in_stretches(s, returned<kTangent>(hencky_strain<3>(s), history));
  }

  ELASTOGEN_HD Returned<T> commit(const HenckyStrain<T, 3>& e, History& history) const {
    return commit_flow(*this, e, history);
  }
  ELASTOGEN_HD void commit(T s[3], History& history) const {
    commit_stretches<3>(*this, s, history);
  }
};

}  // namespace elastogen
