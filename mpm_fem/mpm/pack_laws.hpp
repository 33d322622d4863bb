// SPDX-License-Identifier: Apache-2.0
// The laws of the particles of a pack: each lane has its own, stretches and rotations are worked on
// at once.

#pragma once

#include "mpm_fem/materials/solid.hpp"
#include "mpm_fem/mpm/lanes.hpp"
#include "mpm_fem/mpm/particles.hpp"

namespace elastogen::mpm {

inline Mat3<double> derivative(const NonsymmetricResponse<double>& r) {
  return r.D;
}
inline Mat3<double> derivative(const Response<double>& r) {
  return {r.H[0], r.H[3], r.H[5], r.H[3], r.H[1], r.H[4], r.H[5], r.H[4], r.H[2]};
}

/// Principal stresses t of Piola [Pa] of a pack's particles, and with kTangent the derivative D.
/// @param sigma  stretches of the trial
template <bool kTangent, int d>
void respond(const std::vector<PointLaw<d>>& laws, const Particles& p, const CellPack& pack,
             const Eight sigma[3], Eight t[3], Mat3<Eight>* D) {
  for (int lane = 0; lane < kLanes; ++lane) {
    const int32_t k = pack.particle[lane];
    const double s[3] = {sigma[0][lane], sigma[1][lane], sigma[2][lane]};
    if (lane >= pack.count) {  // finite, and no more
      for (int i = 0; i < 3; ++i) t[i][lane] = 0;
      if constexpr (kTangent) set_lane(lane, {}, *D);
      continue;
    }
    std::visit(
        [&](const auto& law) {
          const auto r = law.template response<kTangent>(s, history_of(law, p.history(k)));
          for (int i = 0; i < 3; ++i) t[i][lane] = r.t[i];
          if constexpr (kTangent) set_lane(lane, derivative(r), *D);
        },
        laws[size_t(p.solid(k))]);
  }
}

/// dP/dF in the principal frame, from respond.
inline PrincipalHessian<Eight, Mat3<Eight>> hessian_lanes(const Eight sigma[3], const Eight t[3],
                                                          const Mat3<Eight>& D) {
  return principal_hessian(sigma, NonsymmetricResponse<Eight>{{}, {t[0], t[1], t[2]}, D});
}

/// A symmetric, positive stand-in for dP/dF of a plastic law: of the coupling of volume and shear in
/// dtau/de it keeps what is mutual. What makes the strength follow the pressure, but not the pressure
/// the shear, is left out: it is nilpotent, so that the stand-in's inverse times the true tangent has
/// the eigenvalues 1, which its symmetric part would not give.
template <int d>
PrincipalHessian<Eight> frozen_hessian(const Eight s[3], const Eight t[3],
                                       PrincipalHessian<Eight, Mat3<Eight>> h) {
  Mat3<Eight>& D = h.A;
  for (int i = 0; i < d; ++i) {  // from stretches to e = ln s
    for (int j = 0; j < d; ++j) D(i, j) *= s[i] * s[j];
    D(i, i) += t[i] * s[i];
  }
  Eight of_volume[d], of_mean[d], sum = {};  // D 1 and D^T 1
  for (int i = 0; i < d; ++i) {
    of_volume[i] = of_mean[i] = Eight{};
    for (int j = 0; j < d; ++j) of_volume[i] += D(i, j), of_mean[i] += D(j, i);
    sum += of_volume[i];
  }
  for (int i = 0; i < d; ++i) {
    const Eight a = of_volume[i] - sum / d, b = of_mean[i] - sum / d;
    const Eight mutual = a * b > 0 ? (absolute(a) < absolute(b) ? a : b) : Eight{};
    for (int j = 0; j < d; ++j) D(i, j) -= (a - mutual) / d, D(j, i) -= (b - mutual) / d;
  }
  for (int i = 0; i < d; ++i) {
    D(i, i) -= t[i] * s[i];
    for (int j = 0; j < d; ++j) D(i, j) /= s[i] * s[j];
  }
  return positive_part(h);
}

}  // namespace elastogen::mpm
