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

/// s ln(j)/3 and its first two derivatives.
struct Dilatation {
  double value, first, second;
};

/// Fbar_q and its factors.
struct MeanDilatation {
  Mat3<double> F[kMaxPoints], Fbar[kMaxPoints];
  double r[kMaxPoints];
  Dilatation own[kMaxPoints], mean;  ///< of J_q and of Jbar
  double volume = 0;                 ///< sum_q w_q [m^3]
};
/// @param share  exponent s of r_q = (j(Jbar)/j(J_q))^(s/3); below 1 a point keeps a part of its
///               own dilatation (Moran, Ortiz, Shih 1990)
MeanDilatation mean_dilatation(const ElementState& e, double share = 1);

/// Adds sum_q w_q P_q : dFbar_q/du [N] to f, (nodes, 3): dE/du where P = dpsi/dF at Fbar [Pa].
void add_mean_dilatation_gradient(const ElementState& e, const MeanDilatation& m,
                                  const Mat3<double>* P, double* f);
/// The derivative of this gradient [N/m], row-major (3 nodes, 3 nodes).
/// @param A          dP_q/dF at Fbar [Pa], (points, 9, 9)
/// @param symmetric  whether all A are symmetric; then K is, to the bit
void mean_dilatation_hessian(const ElementState& e, const MeanDilatation& m, const Mat3<double>* P,
                             const double* A, bool symmetric, double* K);

}  // namespace elastogen::fem
