// SPDX-License-Identifier: Apache-2.0
// Targets of the fits of many nets at common strains: energy, stress and tangent of each material
// by core/elastic_law.hpp, computed in double, stored in float. Young's modulus is 1.

#pragma once

#include "training/fit_material.hpp"

namespace elastogen {

/// Targets of all pairs of material and strain; row-major.
struct LawTargets {
  float* psi;      ///< energy density [E], (materials, strains)
  float* t;        ///< dpsi/dsigma [E], (materials, 3, strains)
  float* H;        ///< d2psi/dsigma2 [E], 00 11 22 01 12 20, (materials, 6, second)
  int64_t second;  ///< H is written for this many strains, the first ones
};

/// Response of one material at principal log stretches e.
ELASTOGEN_HD inline Response<double> target_response(const TargetLaw& material, const double e[3]) {
  const double s[3] = {std::exp(e[0]), std::exp(e[1]), std::exp(e[2])};
  Response<double> sum{};
  for (int k = 0; k < material.terms; ++k) {
    const Response<double> r = elastic_response<true>(material.law[k], s);
    const double weight = material.weight[k];
    sum.psi += weight * r.psi;
    for (int i = 0; i < 3; ++i) sum.t[i] += weight * r.t[i];
    for (int i = 0; i < 6; ++i) sum.H[i] += weight * r.H[i];
  }
  return sum;
}

/// Writes the targets of pair k = material * strains + strain.
ELASTOGEN_HD inline void write_target(const TargetLaw* materials, const double* e, int64_t strains,
                                      int64_t k, const LawTargets& to) {
  const int64_t m = k / strains, s = k % strains;
  const Response<double> r = target_response(materials[m], e + 3 * s);
  to.psi[k] = float(r.psi);
  for (int i = 0; i < 3; ++i) to.t[(3 * m + i) * strains + s] = float(r.t[i]);
  if (s >= to.second) return;
  for (int i = 0; i < 6; ++i) to.H[(6 * m + i) * to.second + s] = float(r.H[i]);
}

namespace cpu {
/// @param e  principal log stretches, (strains, 3)
void law_targets(const TargetLaw* materials, int64_t count, const double* e, int64_t strains,
                 const LawTargets& to);
}  // namespace cpu

namespace cuda {
/// cpu::law_targets with pointers of the current device, on its default stream.
void law_targets(const TargetLaw* materials, int64_t count, const double* e, int64_t strains,
                 const LawTargets& to);
}  // namespace cuda
}  // namespace elastogen
