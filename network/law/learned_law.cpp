// SPDX-License-Identifier: Apache-2.0
#include "network/law/learned_law_impl.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

/// Cells of a table in a unit of log stretch. Gent's law needs more where its limit is in or near
/// the box, because the weight of the net falls to 0 within a few cells there.
int table_cells(const Law& law) {
  return law.kind == Law::Kind::kGent && law.shape < 12 ? 24 : 16;
}

/// The log stretches of a list at which the net has weight, and their indices in it.
struct Reached {
  std::vector<double> e;
  std::vector<int64_t> index;
};

Reached reached_by_net(const Law& law, const double* e, int64_t n) {
  Reached reached;
  for (int64_t k = 0; k < n; ++k) {
    if (learned::weight(law, e + 3 * k).psi == 0) continue;
    reached.e.insert(reached.e.end(), e + 3 * k, e + 3 * k + 3);
    reached.index.push_back(k);
  }
  return reached;
}

/// Evaluates the net for all lanes in one call.
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
    result[reached.index[m]] = learned::difference(law, place, jets[m]);
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
        learned::weight(law_, place).psi * (by_net[m] - elastic_response<false>(law, s).psi);
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
