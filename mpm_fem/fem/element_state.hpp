// SPDX-License-Identifier: Apache-2.0
// One displaced element, and the operations of every element at a quadrature point: deformation
// gradient, its transpose applied to a stress, and the product with a tangent.

#pragma once

#include "core/mat3.hpp"
#include "mpm_fem/fem/shape_functions.hpp"

namespace elastogen::fem {

struct ElementState {
  int nodes, points;
  const double* gradient;     ///< dN_a/dX [1/m], (points, nodes, 3)
  double weight[kMaxPoints];  ///< w_q, fill included [m^3]
  double u[kMaxDofs];         ///< displacement relative to the first node [m], (nodes, 3)

  const double* gradient_at(int q) const { return gradient + 3 * nodes * q; }
};

/// A : B.
double inner(const Mat3<double>& A, const Mat3<double>& B);

/// F_q = I + sum_a u_a (x) dN_a/dX.
Mat3<double> deformation_gradient(const ElementState& e, int q);

/// Adds P dN_a/dX to f, (nodes, 3): the derivative of P : F_q in u.
void add_transposed(const ElementState& e, int q, const Mat3<double>& P, double* f);

/// Adds G^T D G to the upper triangle of K, row-major (3 nodes, 3 nodes), with G the map from u to
/// F_q and D symmetric, (9, 9).
void add_product(const ElementState& e, int q, const double* D, double* K);

/// Adds all of G^T D G; D need not be symmetric.
void add_full_product(const ElementState& e, int q, const double* D, double* K);

/// Copies the upper triangle of K, (size, size), to the lower one.
void mirror(int size, double* K);

}  // namespace elastogen::fem
