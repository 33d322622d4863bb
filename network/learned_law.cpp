// SPDX-License-Identifier: Apache-2.0
#include "network/learned_law.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

constexpr int kFirstAxis[6] = {0, 1, 2, 0, 1, 2}, kSecondAxis[6] = {0, 1, 2, 1, 2, 0};

/// r = 1 - (10 x^3 - 15 x^4 + 6 x^5), x = (|y| - from)/(to - from), with derivatives in y.
struct Ramp {
  double value = 1, first = 0, second = 0;
};

Ramp ramp(double y, double from, double to) {
  const double x = (std::abs(y) - from) / (to - from);
  if (x <= 0) return {};
  if (x >= 1) return {0, 0, 0};
  const double scale = (y < 0 ? -1 : 1) / (to - from);
  return {1 - x * x * x * (10 + x * (6 * x - 15)), -30 * x * x * (1 - x) * (1 - x) * scale,
          -60 * x * (1 - x) * (1 - 2 * x) / ((to - from) * (to - from))};
}

/// a b with its derivatives.
LogJet product(const LogJet& a, const LogJet& b) {
  LogJet r;
  r.psi = a.psi * b.psi;
  for (int i = 0; i < 3; ++i) r.w[i] = a.psi * b.w[i] + a.w[i] * b.psi;
  for (int c = 0; c < 6; ++c) {
    const int i = kFirstAxis[c], j = kSecondAxis[c];
    r.ww[c] = a.psi * b.ww[c] + a.w[i] * b.w[j] + a.w[j] * b.w[i] + a.ww[c] * b.psi;
  }
  return r;
}

/// r(y(e)) with its derivatives, y_i and y_ij those of y.
LogJet composed(const Ramp& r, const double y_i[3], const double y_ij[6]) {
  LogJet jet;
  jet.psi = r.value;
  for (int i = 0; i < 3; ++i) jet.w[i] = r.first * y_i[i];
  for (int c = 0; c < 6; ++c)
    jet.ww[c] = r.second * y_i[kFirstAxis[c]] * y_i[kSecondAxis[c]] + r.first * y_ij[c];
  return jet;
}

/// The factor of the limit of I1 - 3 = sum E_i - 3, E_i = exp(2 e'_i).
LogJet limit_weight(const double e[3], double limit) {
  const double mean = (e[0] + e[1] + e[2]) / 3;
  double E[3], y_i[3], y_ij[6];
  for (int i = 0; i < 3; ++i) E[i] = std::exp(2 * (e[i] - mean)) / limit;
  const double sum = E[0] + E[1] + E[2];
  for (int i = 0; i < 3; ++i) y_i[i] = 2 * E[i] - 2 * sum / 3;
  for (int c = 0; c < 6; ++c) {
    const double Ei = E[kFirstAxis[c]], Ej = E[kSecondAxis[c]];
    y_ij[c] = (c < 3 ? 4 * Ei : 0) - 4 * (Ei + Ej) / 3 + 4 * sum / 9;
  }
  return composed(ramp(sum - 3 / limit, kFittedShare, kBlendedShare), y_i, y_ij);
}

/// w and its derivatives in e.
LogJet weight(const Law& law, const double e[3]) {
  constexpr double kOne[3] = {1, 1, 1}, kNone[6] = {};
  LogJet w = composed(ramp(e[0] + e[1] + e[2], kFittedTrace, kBlendedTrace), kOne, kNone);
  for (int i = 0; i < 3 && w.psi > 0; ++i) {
    double axis[3] = {};
    axis[i] = 1;
    w = product(w, composed(ramp(e[i], kFittedStretch, kBlendedStretch), axis, kNone));
  }
  return law.kind == Law::Kind::kGent && w.psi > 0 ? product(w, limit_weight(e, law.shape)) : w;
}

/// A law's response in log stretches: w_i = t_i s_i, w_ij = H_ij s_i s_j + d_ij w_i.
LogJet in_logs(const LawParameters<double>& law, const double e[3]) {
  double s[3];
  for (int i = 0; i < 3; ++i) s[i] = std::exp(e[i]);
  const Response<double> r = elastic_response<true>(law, s);
  LogJet jet;
  jet.psi = r.psi;
  for (int i = 0; i < 3; ++i) jet.w[i] = r.t[i] * s[i];
  for (int c = 0; c < 6; ++c)
    jet.ww[c] = r.H[c] * s[kFirstAxis[c]] * s[kSecondAxis[c]] + (c < 3 ? jet.w[c] : 0);
  return jet;
}

/// a - b with its derivatives.
LogJet gap(const LogJet& a, const LogJet& b) {
  LogJet r;
  r.psi = a.psi - b.psi;
  for (int i = 0; i < 3; ++i) r.w[i] = a.w[i] - b.w[i];
  for (int c = 0; c < 6; ++c) r.ww[c] = a.ww[c] - b.ww[c];
  return r;
}

/// Cells of a table in a unit of log stretch: a limit of Gent's law in or near the box takes the
/// net back within a few of them.
int table_cells(const Law& law) {
  return law.kind == Law::Kind::kGent && law.shape < 12 ? 24 : 16;
}

/// Those of some log stretches where the net has a say, and their places.
struct Reached {
  std::vector<double> e;
  std::vector<int64_t> index;
};

Reached reached_by_net(const Law& law, const double* e, int64_t n) {
  Reached reached;
  for (int64_t k = 0; k < n; ++k) {
    if (weight(law, e + 3 * k).psi == 0) continue;
    reached.e.insert(reached.e.end(), e + 3 * k, e + 3 * k + 3);
    reached.index.push_back(k);
  }
  return reached;
}

/// By the net, lane by lane packed into one call.
template <bool kHessian, class T>
LogResponse<T> by_net(const LearnedLaw& learned, const T e[3]) {
  using S = Scalar<T>;
  constexpr int kCount = is_pack<T> ? kLanes : 1;
  const auto lane = [](auto& value, int l) -> auto& {
    if constexpr (is_pack<T>)
      return value[l];
    else
      return value;
  };
  double logs[3 * kCount];
  LogJet jets[kCount];
  for (int l = 0; l < kCount; ++l)
    for (int i = 0; i < 3; ++i) logs[3 * l + i] = double(lane(e[i], l));
  learned.difference<kHessian>(logs, kCount, jets);
  LogResponse<T> r;
  for (int l = 0; l < kCount; ++l) {
    lane(r.psi, l) = S(jets[l].psi);
    for (int i = 0; i < 3; ++i) lane(r.w[i], l) = S(jets[l].w[i]);
    for (int c = 0; c < 6; ++c) lane(r.ww[c], l) = S(jets[l].ww[c]);
  }
  return r;
}

}  // namespace

LearnedLaw::LearnedLaw(std::span<const float> weights, Law law, double poisson, std::string hash,
                       Evaluation evaluation)
    : weights_(weights.begin(), weights.end()),
      net_(weights, poisson),
      law_(law),
      poisson_(poisson),
      hash_(std::move(hash)),
      evaluation_(evaluation) {
  if (evaluation != Evaluation::kTable) return;
  table_ = MtlTable([this](const double* e, int64_t n, double* psi) { difference(e, n, psi); },
                    table_cells(law));
}

template <bool kHessian>
void LearnedLaw::difference(const double* e, int64_t n, LogJet* result) const {
  const LawParameters<double> law{law_, net_.mu(), net_.lambda()};
  const Reached reached = reached_by_net(law_, e, n);
  std::vector<LogJet> jets(reached.index.size());
  net_.evaluate<kHessian>(reached.e.data(), int64_t(jets.size()), jets.data());
  std::fill_n(result, n, LogJet{});
  for (size_t m = 0; m < jets.size(); ++m) {
    const double* place = reached.e.data() + 3 * m;
    result[reached.index[m]] = product(weight(law_, place), gap(jets[m], in_logs(law, place)));
  }
}

void LearnedLaw::difference(const double* e, int64_t n, double* psi) const {
  const LawParameters<double> law{law_, net_.mu(), net_.lambda()};
  const Reached reached = reached_by_net(law_, e, n);
  std::vector<double> by_net(reached.index.size());
  net_.evaluate(reached.e.data(), int64_t(by_net.size()), by_net.data());
  std::fill_n(psi, n, 0.0);
  for (size_t m = 0; m < by_net.size(); ++m) {
    const double* place = reached.e.data() + 3 * m;
    double s[3];
    for (int i = 0; i < 3; ++i) s[i] = std::exp(place[i]);
    psi[reached.index[m]] =
        weight(law_, place).psi * (by_net[m] - elastic_response<false>(law, s).psi);
  }
}

template void LearnedLaw::difference<false>(const double*, int64_t, LogJet*) const;
template void LearnedLaw::difference<true>(const double*, int64_t, LogJet*) const;

template <bool kHessian, class T>
Response<T> learned_response(const LearnedLaw& learned, const LawParameters<Scalar<T>>& law,
                             const T s[3], T& outside) {
  if (learned.evaluation() == Evaluation::kTable)
    return corrected_response<kHessian>(
        law, s, [&](const T e[3]) { return learned.table().evaluate<kHessian>(e); }, outside);
  return corrected_response<kHessian>(
      law, s, [&](const T e[3]) { return by_net<kHessian>(learned, e); }, outside);
}

template <class T>
LogResponse<T> learned_difference(const LearnedLaw& learned, const T e[3]) {
  return learned.evaluation() == Evaluation::kTable ? learned.table().evaluate<false>(e)
                                                    : by_net<false>(learned, e);
}

template LogResponse<double> learned_difference(const LearnedLaw&, const double[3]);
template LogResponse<Pack<float>> learned_difference(const LearnedLaw&, const Pack<float>[3]);
template LogResponse<Pack<double>> learned_difference(const LearnedLaw&, const Pack<double>[3]);

#define ELASTOGEN_LEARNED(H, T) \
  template Response<T> learned_response<H, T>(const LearnedLaw&, const LawParameters<Scalar<T>>&, \
                                              const T[3], T&);
ELASTOGEN_LEARNED(false, double)
ELASTOGEN_LEARNED(true, double)
ELASTOGEN_LEARNED(false, Pack<float>)
ELASTOGEN_LEARNED(true, Pack<float>)
ELASTOGEN_LEARNED(false, Pack<double>)
ELASTOGEN_LEARNED(true, Pack<double>)
#undef ELASTOGEN_LEARNED

}  // namespace elastogen
