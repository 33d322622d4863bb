// SPDX-License-Identifier: Apache-2.0
#include "network/learned_law.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

constexpr int kCells = 16;  // of a table, in a unit of log stretch
constexpr int kFirst[6] = {0, 1, 2, 0, 1, 2}, kSecond[6] = {0, 1, 2, 1, 2, 0};

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

/// w and its derivatives in e.
LogJet weight(const double e[3]) {
  const Ramp trace = ramp(e[0] + e[1] + e[2], kFittedTrace, kBlendedTrace);
  Ramp r[3];
  for (int i = 0; i < 3; ++i) r[i] = ramp(e[i], kFittedStretch, kBlendedStretch);
  const double all = r[0].value * r[1].value * r[2].value;
  double one[3], two[6];  // derivatives of the product of the three
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    one[i] = r[i].first * r[j].value * r[k].value;
    two[i] = r[i].second * r[j].value * r[k].value;
    two[3 + i] = r[i].first * r[j].first * r[k].value;
  }
  LogJet w;
  w.psi = all * trace.value;
  for (int i = 0; i < 3; ++i) w.w[i] = one[i] * trace.value + all * trace.first;
  for (int c = 0; c < 6; ++c)
    w.ww[c] = two[c] * trace.value + (one[kFirst[c]] + one[kSecond[c]]) * trace.first +
              all * trace.second;
  return w;
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
    jet.ww[c] = r.H[c] * s[kFirst[c]] * s[kSecond[c]] + (c < 3 ? jet.w[c] : 0);
  return jet;
}

/// w (a - b) with its derivatives.
LogJet weighted_gap(const LogJet& w, const LogJet& a, const LogJet& b) {
  LogJet r;
  const double gap = a.psi - b.psi;
  double slope[3];
  for (int i = 0; i < 3; ++i) slope[i] = a.w[i] - b.w[i];
  r.psi = w.psi * gap;
  for (int i = 0; i < 3; ++i) r.w[i] = w.psi * slope[i] + w.w[i] * gap;
  for (int c = 0; c < 6; ++c) {
    const int i = kFirst[c], j = kSecond[c];
    r.ww[c] = w.psi * (a.ww[c] - b.ww[c]) + w.w[i] * slope[j] + w.w[j] * slope[i] + w.ww[c] * gap;
  }
  return r;
}

/// Those of some log stretches where the net has a say, and their places.
struct Reached {
  std::vector<double> e;
  std::vector<int64_t> index;
};

Reached reached_by_net(const double* e, int64_t n) {
  Reached reached;
  for (int64_t k = 0; k < n; ++k) {
    if (weight(e + 3 * k).psi == 0) continue;
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
  table_ =
      MtlTable([this](const double* e, int64_t n, double* psi) { difference(e, n, psi); }, kCells);
}

template <bool kHessian>
void LearnedLaw::difference(const double* e, int64_t n, LogJet* result) const {
  const LawParameters<double> law{law_, net_.mu(), net_.lambda()};
  const Reached reached = reached_by_net(e, n);
  std::vector<LogJet> jets(reached.index.size());
  net_.evaluate<kHessian>(reached.e.data(), int64_t(jets.size()), jets.data());
  std::fill_n(result, n, LogJet{});
  for (size_t m = 0; m < jets.size(); ++m) {
    const double* place = reached.e.data() + 3 * m;
    result[reached.index[m]] = weighted_gap(weight(place), jets[m], in_logs(law, place));
  }
}

void LearnedLaw::difference(const double* e, int64_t n, double* psi) const {
  const LawParameters<double> law{law_, net_.mu(), net_.lambda()};
  const Reached reached = reached_by_net(e, n);
  std::vector<double> by_net(reached.index.size());
  net_.evaluate(reached.e.data(), int64_t(by_net.size()), by_net.data());
  std::fill_n(psi, n, 0.0);
  for (size_t m = 0; m < by_net.size(); ++m) {
    const double* place = reached.e.data() + 3 * m;
    double s[3];
    for (int i = 0; i < 3; ++i) s[i] = std::exp(place[i]);
    psi[reached.index[m]] = weight(place).psi * (by_net[m] - elastic_response<false>(law, s).psi);
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
