// SPDX-License-Identifier: Apache-2.0
// The potentials of the particles of a pack: that of the law or, if it has none, the one that is
// frozen at a state (frozen_law.hpp).

#pragma once

#include "mpm_fem/materials/frozen_law.hpp"
#include "mpm_fem/mpm/pack_laws.hpp"

namespace elastogen::mpm {

/// Freezes laws without a potential at a pack's stretches sigma.
template <int d>
void freeze(const std::vector<PointLaw<d>>& laws, const Particles& p, const CellPack& pack,
            const Eight sigma[3], std::vector<FrozenPoint<d>>& frozen) {
  for (int lane = 0; lane < pack.count; ++lane) {
    const int32_t k = pack.particle[lane];
    const double s[3] = {sigma[0][lane], sigma[1][lane], sigma[2][lane]};
    std::visit(
        [&]<class L>(const L& law) {
          if constexpr (!has_energy<L>)
            frozen[size_t(k)] = FrozenLaw<L>{law}.frozen(s, history_of(law, p.history(k)));
        },
        laws[size_t(p.solid(k))]);
  }
}

/// As respond of pack_laws.hpp, with these potentials. @return psi [J/m^3]
template <bool kTangent, int d>
Eight respond(const std::vector<PointLaw<d>>& laws, const Particles& p,
              const std::vector<FrozenPoint<d>>& frozen, const CellPack& pack, const Eight sigma[3],
              Eight t[3], Mat3<Eight>* D) {
  Eight psi = {};
  t[0] = t[1] = t[2] = Eight{};
  if constexpr (kTangent) *D = {};
  for (int lane = 0; lane < pack.count; ++lane) {
    const int32_t k = pack.particle[lane];
    const double s[3] = {sigma[0][lane], sigma[1][lane], sigma[2][lane]};
    // puts the response of a law into the lane
    const auto take = [&](const Response<double>& r) {
      psi[lane] = r.psi;
      for (int i = 0; i < 3; ++i) t[i][lane] = r.t[i];
      if constexpr (kTangent) set_lane(lane, derivative(r), *D);
    };
    // the law's own potential, or the frozen one
    std::visit(
        [&]<class L>(const L& law) {
          if constexpr (has_energy<L>) {
            take(law.template response<kTangent>(s, history_of(law, p.history(k))));
          } else {
            const FrozenLaw<L> potential{law};
            using History = typename FrozenLaw<L>::History;
            take(potential.template response<kTangent>(s, std::get<History>(frozen[size_t(k)])));
          }
        },
        laws[size_t(p.solid(k))]);
  }
  return psi;
}

}  // namespace elastogen::mpm
