// SPDX-License-Identifier: Apache-2.0
// RNN-1's local step, for a voxel or a row of eight: from corner displacements to the deformation
// gradient, the response of its material (a law or a net), and the forces on its corners.

#pragma once

#include "core/principal.hpp"
#include "core/strain_law.hpp"
#include "core/tangent.hpp"
#include "network/potential/voxel_damping.hpp"

namespace elastogen {

/// Energy of the strain-variance and torsion terms [J]; adds its derivative in the pattern sums to
/// slope. Quadratic: with g the pattern sums of a direction, slope is the product with its Hessian.
template <bool kBorder, class T>
ELASTOGEN_HD inline T hourglass_energy(const VoxelData<T>& v, const T g[3][8], T slope[3][8]) {
  if (v.hourglass == Hourglass::kOff) return T{};
  T q[3][4], s[3][4], energy{};
  for (int i = 0; i < 3; ++i) {
    hex8::centred_patterns<kBorder>(g[i], v.M, q[i]);
    energy += hex8::variance(q[i], v.c, s[i]);
  }
  if (v.hourglass == Hourglass::kFull)
    energy += hex8::torsion(q, v.c, constant<T>(v.law.mu), v.R, s);
  const T weight = v.phi * v.h;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 4; ++k) s[i][k] = s[i][k] * weight;
    hex8::add_centred_transposed<kBorder>(s[i], v.M, slope[i]);
  }
  return energy * weight;
}

/// Energies of a voxel [J] and its det F; outside: 1 where F is out of the box of a net.
template <class T>
struct VoxelEnergy {
  T elastic, hourglass, viscous, J, outside;
};

/// psi, P and det F at F = I + H by stretches.
/// @param outside  as that of the response.
template <class T, class Respond>
ELASTOGEN_HD inline StrainResponse<T> stress_by_stretches(const Respond& respond, const Mat3<T>& H,
                                                          T& outside) {
  const Svd3<T> F = svd3(plus_identity(H));
  const Response<T> r = respond(F.sigma, outside);
  return {r.psi, F.sigma[0] * F.sigma[1] * F.sigma[2], first_piola(F, r.t)};
}

/// Response of a voxel's material: that of its net, or of its law.
template <class T>
struct MaterialResponse {
  const LearnedLaw* learned;
  LawParameters<Scalar<T>> law;

  bool has_net() const { return learned != nullptr; }
  LogResponse<T> difference(const T e[3]) const { return learned_difference(*learned, e); }
  Response<T> operator()(const T sigma[3], T& outside) const {
    return material_response<false>(learned, law, sigma, outside);
  }
};

/// Energy of a voxel and its derivative f [N] in corner displacements u [m] (component, corner).
/// `respond(sigma, outside)` is the response of its material to stretches. A law of strains needs
/// no stretches; respond.difference(e) then gives the correction by its net, if it has_net().
/// @param damping  null: none.
template <bool kBorder, class T, class Respond>
ELASTOGEN_HD inline VoxelEnergy<T> voxel_energy(const VoxelData<T>& v, const Respond& respond,
                                                const T u[3][8], T f[3][8],
                                                const VoxelDamping<T>* damping = nullptr) {
  using S = Scalar<T>;
  T g[3][8];
  for (int i = 0; i < 3; ++i) {
    for (int c = 0; c < 8; ++c) g[i][c] = u[i][c], f[i][c] = T{};
    hex8::to_patterns(g[i]);
  }
  VoxelEnergy<T> energy;
  const Mat3<T> H = displacement_gradient<kBorder>(v, g);
  // stress from strains if the law and F allow it, else from stretches
  StrainResponse<T> r;
  energy.outside = T{};
  const auto difference = [&](const T e[3]) { return respond.difference(e); };
  const auto add = [&](const Symmetric3<T>& E, T& psi, Symmetric3<T>& S) {
    if (respond.has_net()) add_difference(v.law, E, difference, psi, S, energy.outside);
  };
  if (!is_law_of_strain(v.law.law) || !strain_response(v.law, H, add, r))
    r = stress_by_stretches(respond, H, energy.outside);

  // energies, and forces at the corners
  energy.viscous = T{};
  if (damping) energy.viscous = damping_energy<kBorder>(v, *damping, g, H, r.P, f);
  energy.elastic = v.phi * (v.h * v.h * v.h) * r.psi;
  energy.J = r.J;
  const T weight = v.phi * (v.h * v.h * S(0.25));  // phi h^3 / (4 h)
  for (int i = 0; i < 3; ++i) {
    const T d[3] = {r.P(i, 0) * weight, r.P(i, 1) * weight, r.P(i, 2) * weight};
    hex8::add_gradient_transposed<kBorder>(d, v.M, f[i]);
  }
  energy.hourglass = hourglass_energy<kBorder>(v, g, f);
  for (int i = 0; i < 3; ++i) hex8::to_corners(f[i]);
  return energy;
}

/// voxel_energy with the voxel's own material.
template <bool kBorder, class T>
inline VoxelEnergy<T> voxel_energy(const VoxelData<T>& v, const T u[3][8], T f[3][8],
                                   const VoxelDamping<T>* damping = nullptr) {
  return voxel_energy<kBorder>(v, MaterialResponse<T>{v.learned, v.law}, u, f, damping);
}

/// Smallest det F over the corners of a voxel: there the gradient is the difference along edges.
template <class T>
ELASTOGEN_HD inline T corner_jacobian(const T u[3][8], Scalar<T> h) {
  T least = constant<T>(Scalar<T>(1e30));
  for (int c = 0; c < 8; ++c) {
    Mat3<T> F;
    for (int i = 0; i < 3; ++i)
      for (int d = 0; d < 3; ++d) {
        const int low = c & ~(1 << d), high = c | 1 << d;
        F(i, d) = (u[i][high] - u[i][low]) / h;
        if (i == d) F(i, d) = F(i, d) + 1;
      }
    least = smaller(least, determinant(F));
  }
  return least;
}

/// Upper triangle of d2psi/dF2 [Pa], row-major over the nine entries of F.
template <class T>
struct Tangent {
  T m[45];
};

/// Tangent of a voxel at corner displacements u; `respond(sigma, outside)` is the response of its
/// material, with second derivatives.
template <bool kBorder, class T, class Respond>
ELASTOGEN_HD inline Tangent<T> voxel_tangent(const VoxelData<T>& v, const Respond& respond,
                                             const T u[3][8],
                                             TangentKind kind = TangentKind::kProjected,
                                             const VoxelDamping<T>* damping = nullptr) {
  T g[3][8];
  for (int i = 0; i < 3; ++i) {
    for (int c = 0; c < 8; ++c) g[i][c] = u[i][c];
    hex8::to_patterns(g[i]);
  }
  // by stretches, then column by column
  const Mat3<T> gradient = displacement_gradient<kBorder>(v, g);
  const Svd3<T> F = svd3(plus_identity(gradient));
  T outside;
  const Response<T> r = respond(F.sigma, outside);
  PrincipalHessian<T> H = principal_hessian(F.sigma, r);
  if (kind == TangentKind::kProjected) H = positive_part(H);
  Tangent<T> result;
  for (int row = 0, k = 0; row < 9; ++row) {
    Mat3<T> unit{};
    unit.m[row] = constant<T>(1);
    Mat3<T> column = apply(H, F, unit);
    if (damping)
      add_viscous_tangent(damping->moduli(v), gradient, damping->before.E, kind, unit, column);
    for (int col = row; col < 9; ++col) result.m[k++] = column.m[col];
  }
  return result;
}

/// voxel_tangent with the voxel's own material.
template <bool kBorder, class T>
inline Tangent<T> voxel_tangent(const VoxelData<T>& v, const T u[3][8],
                                TangentKind kind = TangentKind::kProjected,
                                const VoxelDamping<T>* damping = nullptr) {
  const auto respond = [&](const T sigma[3], T& outside) {
    return material_response<true>(v.learned, v.law, sigma, outside);
  };
  return voxel_tangent<kBorder>(v, respond, u, kind, damping);
}

/// Product f of a voxel's Hessian with the direction p; `stress(dF, dP)` applies the tangent.
/// @param beta  of the voxel's damping.
template <bool kBorder, class T, class Stress>
ELASTOGEN_HD inline void hessian_product(const VoxelData<T>& v, const Stress& stress,
                                         const T p[3][8], T f[3][8], Scalar<T> beta = 0) {
  using S = Scalar<T>;
  T g[3][8], dF[9], dP[9];
  for (int i = 0; i < 3; ++i) {
    for (int c = 0; c < 8; ++c) g[i][c] = p[i][c], f[i][c] = T{};
    hex8::to_patterns(g[i]);
    hex8::gradient<kBorder>(g[i], v.M, dF + 3 * i);
  }
  stress(dF, dP);
  const T weight = v.phi * (v.h * S(0.0625));  // phi h^3 / (4 h)^2
  for (int i = 0; i < 3; ++i) {
    const T d[3] = {dP[3 * i] * weight, dP[3 * i + 1] * weight, dP[3 * i + 2] * weight};
    hex8::add_gradient_transposed<kBorder>(d, v.M, f[i]);
  }
  hourglass_energy<kBorder>(v, g, f);
  if (beta > 0) add_variance_product<kBorder>(v, beta, g, f);
  for (int i = 0; i < 3; ++i) hex8::to_corners(f[i]);
}

/// Product with the Hessian, by a tangent.
template <bool kBorder, class T>
ELASTOGEN_HD inline void voxel_hessian(const VoxelData<T>& v, const Tangent<T>& tangent,
                                       const T p[3][8], T f[3][8], Scalar<T> beta = 0) {
  const auto stress = [&](const T dF[9], T dP[9]) {
    for (int k = 0; k < 9; ++k) dP[k] = T{};
    for (int row = 0, k = 0; row < 9; ++row) {
      dP[row] += tangent.m[k++] * dF[row];
      for (int col = row + 1; col < 9; ++col, ++k) {
        dP[row] += tangent.m[k] * dF[col];
        dP[col] += tangent.m[k] * dF[row];
      }
    }
  };
  hessian_product<kBorder>(v, stress, p, f, beta);
}

/// Product with the Hessian at rest, which all laws share: dP = mu (dF + dF^T) + lambda tr(dF) I.
template <bool kBorder, class T>
ELASTOGEN_HD inline void voxel_rest_hessian(const VoxelData<T>& v, const T p[3][8], T f[3][8]) {
  const auto stress = [&](const T dF[9], T dP[9]) {
    const T pressure = v.law.lambda * (dF[0] + dF[4] + dF[8]);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        dP[3 * i + j] = v.law.mu * (dF[3 * i + j] + dF[3 * j + i]);
        if (i == j) dP[3 * i + j] += pressure;
      }
  };
  hessian_product<kBorder>(v, stress, p, f);
}

}  // namespace elastogen
