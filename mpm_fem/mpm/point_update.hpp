// SPDX-License-Identifier: Apache-2.0
// What a step leaves at a point: elastic strain, history and stress.

#pragma once

#include "core/svd2.hpp"
#include "mpm_fem/materials/solid.hpp"

namespace elastogen {

/// Kirchhoff's stress U diag(t_i s_i) U^T [Pa], xx yy zz xy yz zx, of Piola's principal stresses t.
inline void write_kirchhoff(const Svd3<double>& F, const double t[3], double stress[6]) {
  constexpr int kRow[6] = {0, 1, 2, 0, 1, 2}, kColumn[6] = {0, 1, 2, 1, 2, 0};
  for (int k = 0; k < 6; ++k) {
    stress[k] = 0;
    for (int i = 0; i < 3; ++i)
      stress[k] += F.U(kRow[k], i) * t[i] * F.sigma[i] * F.U(kColumn[k], i);
  }
}

/// Ends a step at a point: the trial F becomes elastic, the history that after the step, the stress
/// that of the trial.
template <int d, class L>
void end_step(const L& law, Mat3<double>& F, double& memory, double stress[6]) {
  Svd3<double> s = decompose<d>(F);
  typename L::History history = history_of(law, memory);
  write_kirchhoff(s, law.template response<false>(s.sigma, history).t, stress);
  if constexpr (std::is_empty_v<typename L::History>) return;
  law.commit(s.sigma, history);
  memory = memory_of(history);
  F = first_piola(s, s.sigma);
}

}  // namespace elastogen
