// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/fem/element_state.hpp"

namespace elastogen::fem {

double inner(const Mat3<double>& A, const Mat3<double>& B) {
  double sum = 0;
  for (int k = 0; k < 9; ++k) sum += A.m[k] * B.m[k];
  return sum;
}

Mat3<double> deformation_gradient(const ElementState& e, int q) {
  Mat3<double> F = identity<double>();
  const double* g = e.gradient_at(q);
  for (int a = 0; a < e.nodes; ++a)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) F(i, j) += e.u[3 * a + i] * g[3 * a + j];
  return F;
}

void add_transposed(const ElementState& e, int q, const Mat3<double>& P, double* f) {
  const double* g = e.gradient_at(q);
  for (int a = 0; a < e.nodes; ++a)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) f[3 * a + i] += P(i, j) * g[3 * a + j];
}

namespace {

/// Adds the columns of node b of G^T D G in the rows of the first `rows` nodes.
void add_columns(const ElementState& e, int q, const double* D, int b, int rows, double* K) {
  const double* g = e.gradient_at(q);
  const int size = 3 * e.nodes;
  // D times the gradient that a displacement of node b along k makes
  double Dg[9][3] = {};
  for (int ij = 0; ij < 9; ++ij)
    for (int k = 0; k < 3; ++k)
      for (int l = 0; l < 3; ++l) Dg[ij][k] += D[9 * ij + 3 * k + l] * g[3 * b + l];
  for (int a = 0; a < rows; ++a)
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k)
        for (int j = 0; j < 3; ++j)
          K[size * (3 * a + i) + 3 * b + k] += g[3 * a + j] * Dg[3 * i + j][k];
}

}  // namespace

void add_product(const ElementState& e, int q, const double* D, double* K) {
  for (int b = 0; b < e.nodes; ++b) add_columns(e, q, D, b, b + 1, K);
}

void add_full_product(const ElementState& e, int q, const double* D, double* K) {
  for (int b = 0; b < e.nodes; ++b) add_columns(e, q, D, b, e.nodes, K);
}

void mirror(int size, double* K) {
  for (int row = 0; row < size; ++row)
    for (int col = 0; col < row; ++col) K[size * row + col] = K[size * col + row];
}

}  // namespace elastogen::fem
