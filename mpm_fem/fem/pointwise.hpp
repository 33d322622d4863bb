// SPDX-License-Identifier: Apache-2.0
// Elements whose potential is a sum over their points, E = sum_q w_q psi(F_q).

#pragma once

#include "mpm_fem/fem/element_state.hpp"

namespace elastogen::fem {

/// E [J].
double pointwise_energy(const ElementState& e);
/// Adds dE/du [N] to f, (nodes, 3).
void add_pointwise_gradient(const ElementState& e, double* f);
/// The Hessian of E [N/m], row-major (3 nodes, 3 nodes).
/// @param kind  projected: with the negative eigenvalues of each d2psi/dF2 at 0.
void pointwise_hessian(const ElementState& e, TangentKind kind, double* K);

}  // namespace elastogen::fem
