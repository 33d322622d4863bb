// SPDX-License-Identifier: Apache-2.0
// The laws of the particles of a pack: each lane has its own law; stretches and rotations are found
// for all lanes at once.

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
    if (lane >= pack.count) {  // finite, nothing more is needed
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

/// A symmetric, positive substitute for dP/dF of a plastic law. Of the coupling of volume and shear
/// in dtau/de it keeps the mutual part. The one-sided part, by which the strength follows the
/// pressure but the pressure not the shear, is left out. That part is nilpotent, so that the
/// inverse of the substitute times the true tangent has the eigenvalues 1, which the symmetric part
/// of the tangent would not give.
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

/// The block of one node, with z = (Fe V)^T grad w: U M U^T, xx yy zz xy yz zx,
/// M_kk = A_kk z_k^2 + sum_j (flip + twist)/2 z_j^2, M_lk = (A_lk + (flip - twist)/2) z_k z_l.
inline void node_block(const PrincipalHessian<Eight>& h, const Svd3<Eight>& frame, const Eight g[3],
                       Eight block[6]) {
  Eight z[3];
  for (int i = 0; i < 3; ++i)
    z[i] = frame.V(0, i) * g[0] + frame.V(1, i) * g[1] + frame.V(2, i) * g[2];
  Mat3<Eight> M;
  for (int i = 0; i < 3; ++i) M(i, i) = h.A.m[i] * z[i] * z[i];
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    const Eight sum = (h.flip[i] + h.twist[i]) * 0.5, difference = (h.flip[i] - h.twist[i]) * 0.5;
    M(i, i) += sum * z[j] * z[j];
    M(j, j) += sum * z[i] * z[i];
    M(i, j) = M(j, i) = (h.A.m[3 + i] + difference) * z[i] * z[j];
  }
  const Mat3<Eight> UM = frame.U * M;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    block[i] = block[3 + i] = Eight{};
    for (int k = 0; k < 3; ++k) {
      block[i] += UM(i, k) * frame.U(i, k);
      block[3 + i] += UM(i, k) * frame.U(j, k);
    }
  }
}

}  // namespace elastogen::mpm
