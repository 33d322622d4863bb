// SPDX-License-Identifier: Apache-2.0
// The correction of a law by a net (learned_law.hpp), for host and device: the weight w of the net
// and its derivatives in the log stretches e, the law in e, and w (psi_theta - psi_law).

#pragma once

#include "network/law/learned_law.hpp"

namespace elastogen::learned {

/// r = 1 - (10 x^3 - 15 x^4 + 6 x^5), x = (|y| - from)/(to - from), with derivatives in y.
struct Ramp {
  double value = 1, first = 0, second = 0;
};

ELASTOGEN_HD inline Ramp ramp(double y, double from, double to) {
  const double x = (std::abs(y) - from) / (to - from);
  if (x <= 0) return {};
  if (x >= 1) return {0, 0, 0};
  const double scale = (y < 0 ? -1 : 1) / (to - from);
  return {1 - x * x * x * (10 + x * (6 * x - 15)), -30 * x * x * (1 - x) * (1 - x) * scale,
          -60 * x * (1 - x) * (1 - 2 * x) / ((to - from) * (to - from))};
}

/// a b with its derivatives.
ELASTOGEN_HD inline LogJet product(const LogJet& a, const LogJet& b) {
  LogJet r;
  r.psi = a.psi * b.psi;
  for (int i = 0; i < 3; ++i) r.w[i] = a.psi * b.w[i] + a.w[i] * b.psi;
  for (int c = 0; c < 6; ++c) {
    const int i = mtl::entry_row(c), j = mtl::entry_column(c);
    r.ww[c] = a.psi * b.ww[c] + a.w[i] * b.w[j] + a.w[j] * b.w[i] + a.ww[c] * b.psi;
  }
  return r;
}

/// a - b with its derivatives.
ELASTOGEN_HD inline LogJet gap(const LogJet& a, const LogJet& b) {
  LogJet r;
  r.psi = a.psi - b.psi;
  for (int i = 0; i < 3; ++i) r.w[i] = a.w[i] - b.w[i];
  for (int c = 0; c < 6; ++c) r.ww[c] = a.ww[c] - b.ww[c];
  return r;
}

/// r(y(e)) with its derivatives, y_i and y_ij those of y.
ELASTOGEN_HD inline LogJet composed(const Ramp& r, const double y_i[3], const double y_ij[6]) {
  LogJet jet;
  jet.psi = r.value;
  for (int i = 0; i < 3; ++i) jet.w[i] = r.first * y_i[i];
  for (int c = 0; c < 6; ++c)
    jet.ww[c] = r.second * y_i[mtl::entry_row(c)] * y_i[mtl::entry_column(c)] + r.first * y_ij[c];
  return jet;
}

/// The factor of w for the limit of I1 - 3 = sum E_i - 3, E_i = exp(2 e'_i).
ELASTOGEN_HD inline LogJet limit_weight(const double e[3], double limit) {
  const double mean = (e[0] + e[1] + e[2]) / 3;
  double E[3], y_i[3], y_ij[6];
  for (int i = 0; i < 3; ++i) E[i] = std::exp(2 * (e[i] - mean)) / limit;
  const double sum = E[0] + E[1] + E[2];
  for (int i = 0; i < 3; ++i) y_i[i] = 2 * E[i] - 2 * sum / 3;
  for (int c = 0; c < 6; ++c) {
    const double Ei = E[mtl::entry_row(c)], Ej = E[mtl::entry_column(c)];
    y_ij[c] = (c < 3 ? 4 * Ei : 0) - 4 * (Ei + Ej) / 3 + 4 * sum / 9;
  }
  return composed(ramp(sum - 3 / limit, kFittedShare, kBlendedShare), y_i, y_ij);
}

/// w and its derivatives in e.
ELASTOGEN_HD inline LogJet weight(const Law& law, const double e[3]) {
  const double one[3] = {1, 1, 1}, none[6] = {};
  LogJet w = composed(ramp(e[0] + e[1] + e[2], kFittedTrace, kBlendedTrace), one, none);
  for (int i = 0; i < 3 && w.psi > 0; ++i) {
    double axis[3] = {};
    axis[i] = 1;
    w = product(w, composed(ramp(e[i], kFittedStretch, kBlendedStretch), axis, none));
  }
  return law.kind == Law::Kind::kGent && w.psi > 0 ? product(w, limit_weight(e, law.shape)) : w;
}

/// A law's response in log stretches: w_i = t_i s_i, w_ij = H_ij s_i s_j + d_ij w_i.
ELASTOGEN_HD inline LogJet in_logs(const LawParameters<double>& law, const double e[3]) {
  double s[3];
  for (int i = 0; i < 3; ++i) s[i] = std::exp(e[i]);
  const Response<double> r = elastic_response<true>(law, s);
  LogJet jet;
  jet.psi = r.psi;
  for (int i = 0; i < 3; ++i) jet.w[i] = r.t[i] * s[i];
  for (int c = 0; c < 6; ++c)
    jet.ww[c] = r.H[c] * s[mtl::entry_row(c)] * s[mtl::entry_column(c)] + (c < 3 ? jet.w[c] : 0);
  return jet;
}

/// D of psi_theta and its derivatives at e.
/// @param law  with E = 1.
ELASTOGEN_HD inline LogJet difference(const LawParameters<double>& law, const double e[3],
                                      const LogJet& theta) {
  return product(weight(law.law, e), gap(theta, in_logs(law, e)));
}

}  // namespace elastogen::learned
