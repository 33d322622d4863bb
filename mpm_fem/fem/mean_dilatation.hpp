// SPDX-License-Identifier: Apache-2.0
// Elements with mean dilatation (B-bar; Simo, Taylor, Pister 1985) as a potential,
//
//     E = sum_q w_q psi(Fbar_q),   Fbar_q = r_q F_q,   r_q = (j(Jbar)/j(J_q))^(1/3),
//     Jbar = sum_q w_q J_q / sum_q w_q,
//
// with j(J) = J for J >= 1/10. There det Fbar_q = Jbar. As J_q -> 0 the energy would grow beyond
// every bound and below 0 it would not be defined; so j is continued below 1/10, with two
// continuous derivatives, by the positive function
//
//     j(J) = (1/10) / (1 - y + y^2),   y = 10 J - 1.
//
// E is then finite, and its gradient continuous, in every state, also inverted ones; affine states
// have Fbar = F throughout.
//
// Free pieces of few tet10 have zero modes besides the rigid ones: the strain of the conformal
// field u = 2 (b.x) x - |x|^2 b + s x is (2 b.x + s) I, without shape change, and without mean
// dilatation where 2 b.c_e + s = 0 at the centroids c_e: three modes of one element, two of two,
// one of three or of any whose centroids lie in a plane, none of others.

#pragma once

#include "mpm_fem/fem/element_state.hpp"

namespace elastogen::fem {

/// Fbar_q at all points.
void mean_dilatation_gradients(const ElementState& e, Mat3<double>* Fbar);

/// E [J].
double mean_dilatation_energy(const ElementState& e);
/// Adds dE/du [N] to f, (nodes, 3).
void add_mean_dilatation_gradient(const ElementState& e, double* f);
/// The Hessian of E [N/m], row-major (3 nodes, 3 nodes).
/// @param kind  projected: with its negative eigenvalues at 0.
void mean_dilatation_hessian(const ElementState& e, TangentKind kind, double* K);

}  // namespace elastogen::fem
