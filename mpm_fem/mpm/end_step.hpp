// SPDX-License-Identifier: Apache-2.0
// The end of a step at the particles of a pack: laws are evaluated once, for strain and stress.

#pragma once

#include "mpm_fem/mpm/pack_laws.hpp"

namespace elastogen::mpm {

/// Stretches and principal Kirchhoff stress [Pa] after a step, of lanes of one solid.
template <class T>
struct Ended {
  T stretch[3], tau[3];
};

/// Ends the step of lanes [first, last) with a law that flows: strain and stretches in packs, the
/// map lane by lane. Writes the histories.
template <int d, class T, class L>
void end_lanes(const L& law, const int32_t* particle, int first, int last, const T sigma[3],
               Array<double>& history, Ended<T>& r) {
  T e[3] = {}, after[3] = {}, stretch[3] = {sigma[0], sigma[1], sigma[2]}, share[3] = {};
  for (int i = 0; i < d; ++i) {
    const law::Logarithm<T> l = law::continued_log(T(sigma[i] - 1));
    after[i] = e[i] = l.value;
    share[i] = sigma[i] > 0.1 ? constant<T>(1) : l.first * sigma[i];  // of ds/s in de
  }
  for (int lane = first; lane < last; ++lane) {
    double& memory = history(particle[lane]);
    auto own = history_of(law, memory);
    const double strain[3] = {e[0][lane], e[1][lane], e[2][lane]};
    const Returned<double> one = law.commit(split_strain<d>(strain), own);
    for (int i = 0; i < d; ++i) after[i][lane] = one.e[i];
    for (int i = 0; i < 3; ++i) r.tau[i][lane] = one.tau[i] * share[i][lane];
    memory = memory_of(own);
  }
  set_stretches<d>(e, after, stretch);
  for (int i = 0; i < 3; ++i)
    for (int lane = first; lane < last; ++lane) r.stretch[i][lane] = stretch[i][lane];
}
template <int d, class T>
void end_lanes(const ElasticLaw<double>& law, const int32_t*, int first, int last, const T sigma[3],
               Array<double>&, Ended<T>& r) {
  const Response<T> own = elastic_response<false>(law.parameters, sigma);
  for (int i = 0; i < 3; ++i)
    for (int lane = first; lane < last; ++lane) {
      r.stretch[i][lane] = sigma[i][lane];
      r.tau[i][lane] = own.t[i][lane] * sigma[i][lane];
    }
}

/// Ends the step of the lanes of a pack from `begin` on, solid by solid.
template <int d, class T>
Ended<T> ended(const std::vector<PointLaw<d>>& laws, const CellPack& pack, int begin,
               const T sigma[3], Particles& p) {
  const int32_t* particle = pack.particle + begin;
  const int count = std::min(pack.count - begin, lane_count<T>);
  Ended<T> r = {};
  for (int first = 0, last; first < count; first = last) {
    const int32_t solid = p.solid(particle[first]);
    for (last = first + 1; last < count && p.solid(particle[last]) == solid;) ++last;
    std::visit(
        [&](const auto& law) { end_lanes<d>(law, particle, first, last, sigma, p.history, r); },
        laws[size_t(solid)]);
  }
  return r;
}

/// Ends a step at the particles of a pack from the lane `begin` on: stores elastic F, history and
/// Kirchhoff's stress after the step, U diag(tau) U^T with U of the trial F.
template <int d, class T>
void end_step(const std::vector<PointLaw<d>>& laws, const CellPack& pack, int begin,
              const Mat3<T>& trial, Particles& p) {
  constexpr int kRow[6] = {0, 1, 2, 0, 1, 2}, kColumn[6] = {0, 1, 2, 1, 2, 0};
  const Svd3<T> svd = decompose_lanes<d>(trial);
  const Ended<T> end = ended<d>(laws, pack, begin, svd.sigma, p);
  T stress[6] = {};
  for (int k = 0; k < 6; ++k)
    for (int i = 0; i < 3; ++i) stress[k] += svd.U(kRow[k], i) * end.tau[i] * svd.U(kColumn[k], i);
  // where no stretch changed the trial keeps its bits
  auto flows = end.stretch[0] != svd.sigma[0];
  for (int i = 1; i < d; ++i) flows |= end.stretch[i] != svd.sigma[i];
  Mat3<T> F = trial;
  if (any(flows)) {
    const Mat3<T> elastic = first_piola(svd, end.stretch);
    for (int k = 0; k < 9; ++k) F.m[k] = flows ? elastic.m[k] : trial.m[k];
  }
  const int count = std::min(pack.count - begin, lane_count<T>);
  for (int lane = 0; lane < count; ++lane) {
    const int32_t k = pack.particle[begin + lane];
    store_matrix(lane_of(F, lane), p.F.row(k));
    for (int e = 0; e < 6; ++e) p.stress(k, e) = stress[e][lane];
  }
}

}  // namespace elastogen::mpm
