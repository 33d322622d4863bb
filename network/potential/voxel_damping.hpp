// SPDX-License-Identifier: Apache-2.0
// Damping of a voxel (core/viscous.hpp): of its mean strain, and of what varies within it, which is
// all that bends a sheet one voxel thick.

#pragma once

#include "core/viscous.hpp"
#include "network/potential/voxel_data.hpp"

namespace elastogen {

/// What damping (core/viscous.hpp) measures in a voxel: Green's strain E of the mean F, and of what
/// varies within the voxel the centred patterns in the material's frame, A = F^T q. Neither changes
/// where the voxel turns.
template <class T>
struct VoxelStrain {
  static constexpr int kCount = 18;
  T E[6];     ///< 00, 11, 22, 01, 12, 20
  T A[3][4];  ///< [m]
};

template <bool kBorder, class T>
ELASTOGEN_HD inline void turned_patterns(const VoxelData<T>& v, const T g[3][8], const Mat3<T>& F,
                                         T q[3][4], T A[3][4]) {
  for (int i = 0; i < 3; ++i) hex8::centred_patterns<kBorder>(g[i], v.M, q[i]);
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 4; ++k) A[i][k] = F(0, i) * q[0][k] + F(1, i) * q[1][k] + F(2, i) * q[2][k];
}

template <bool kBorder, class T>
ELASTOGEN_HD inline VoxelStrain<T> voxel_strain(const VoxelData<T>& v, const T u[3][8]) {
  T g[3][8], q[3][4];
  for (int i = 0; i < 3; ++i) {
    for (int c = 0; c < 8; ++c) g[i][c] = u[i][c];
    hex8::to_patterns(g[i]);
  }
  VoxelStrain<T> result;
  const Mat3<T> H = displacement_gradient<kBorder>(v, g);
  const Symmetric3<T> E = strain::green(H);
  for (int k = 0; k < 6; ++k) result.E[k] = E.m[k];
  turned_patterns<kBorder>(v, g, plus_identity(H), q, result.A);
  return result;
}

/// Damping of a voxel in a stage: beta and the strain E_b, A_b of core/viscous.hpp.
template <class T>
struct VoxelDamping {
  Scalar<T> beta;
  VoxelStrain<T> before;

  ELASTOGEN_HD ViscousModuli<Scalar<T>> moduli(const VoxelData<T>& v) const {
    return {beta * v.law.mu, beta * v.law.lambda};
  }
};

/// Adds the viscous stress to P, and its part of what varies within the voxel to the slope in the
/// pattern sums: beta times the variance term at A - A_b. @return D of the voxel [J].
template <bool kBorder, class T>
ELASTOGEN_HD inline T damping_energy(const VoxelData<T>& v, const VoxelDamping<T>& damping,
                                     const T g[3][8], const Mat3<T>& H, Mat3<T>& P, T slope[3][8]) {
  const T volume = v.phi * (v.h * v.h * v.h);
  T energy = volume * add_viscous(damping.moduli(v), H, damping.before.E, P);
  if (v.hourglass == Hourglass::kOff) return energy;
  // the patterns, and the derivatives in A, then in q and F
  const Mat3<T> F = plus_identity(H);
  T q[3][4], A[3][4], s[3][4];
  turned_patterns<kBorder>(v, g, F, q, A);
  const T weight = v.phi * (v.h * damping.beta);
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 4; ++k) A[i][k] -= damping.before.A[i][k];
    energy += weight * hex8::variance(A[i], v.c, s[i]);
  }
  const Scalar<T> per_area = damping.beta / (v.h * v.h);
  for (int j = 0; j < 3; ++j) {
    T of_q[4];
    for (int k = 0; k < 4; ++k)
      of_q[k] = weight * (F(j, 0) * s[0][k] + F(j, 1) * s[1][k] + F(j, 2) * s[2][k]);
    hex8::add_centred_transposed<kBorder>(of_q, v.M, slope[j]);
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 4; ++k) P(j, i) += per_area * q[j][k] * s[i][k];
  }
  return energy;
}

/// damping_energy alone: the forces f at the corners [N] where these are displaced by u.
template <bool kBorder, class T>
ELASTOGEN_HD inline T damping_force(const VoxelData<T>& v, const VoxelDamping<T>& damping,
                                    const T u[3][8], T f[3][8]) {
  T g[3][8];
  for (int i = 0; i < 3; ++i) {
    for (int c = 0; c < 8; ++c) g[i][c] = u[i][c], f[i][c] = T{};
    hex8::to_patterns(g[i]);
  }
  Mat3<T> P{};
  const T energy =
      damping_energy<kBorder>(v, damping, g, displacement_gradient<kBorder>(v, g), P, f);
  const T weight = v.phi * (v.h * v.h * Scalar<T>(0.25));  // phi h^3 / (4 h)
  for (int i = 0; i < 3; ++i) {
    const T d[3] = {P(i, 0) * weight, P(i, 1) * weight, P(i, 2) * weight};
    hex8::add_gradient_transposed<kBorder>(d, v.M, f[i]);
    hex8::to_corners(f[i]);
  }
  return energy;
}

/// Adds the variance term's product with the pattern sums g, times a factor: the Hessian of the
/// damping of what varies within a voxel, for F^T F = I.
template <bool kBorder, class T>
ELASTOGEN_HD inline void add_variance_product(const VoxelData<T>& v, Scalar<T> factor,
                                              const T g[3][8], T f[3][8]) {
  if (v.hourglass == Hourglass::kOff) return;
  const T weight = v.phi * (v.h * factor);
  for (int i = 0; i < 3; ++i) {
    T q[4], s[4];
    hex8::centred_patterns<kBorder>(g[i], v.M, q);
    hex8::variance(q, v.c, s);
    for (int k = 0; k < 4; ++k) s[k] = s[k] * weight;
    hex8::add_centred_transposed<kBorder>(s, v.M, f[i]);
  }
}

}  // namespace elastogen
