// SPDX-License-Identifier: Apache-2.0
// Orthonormal columns, of which the first k span the same space as the first k columns of a square
// matrix: Q of A = Q R by Householder's reflections (Golub, Van Loan, Matrix Computations, 5.2), by
// a team of threads that share A, Q and tau.

#pragma once

#include "core/base.hpp"

#include <cmath>

namespace elastogen::householder {

/// A team of one thread, on the host.
struct Alone {
  int lane = 0, lanes = 1;
  void sync() const {}
};

/// H = 1 - tau v v^T with v_0 = 1 that turns a column into beta e_0.
struct Reflection {
  float tau, scale;  ///< v_i = scale a_i below the first entry
};

/// Reflection for column k of A, (n, n), from row k on. Each thread computes it for itself.
ELASTOGEN_HD inline Reflection reflection(const float* A, int n, int k) {
  float below = 0;
  for (int i = k + 1; i < n; ++i) below += A[i * n + k] * A[i * n + k];
  const float alpha = A[k * n + k];
  if (!(below > 0)) return {0, 0};
  const float size = std::sqrt(alpha * alpha + below), beta = alpha > 0 ? -size : size;
  return {(beta - alpha) / beta, 1 / (alpha - beta)};
}

/// Column j of X <- H X, with v below the diagonal of column k of A.
ELASTOGEN_HD inline void reflect(const float* A, float tau, int n, int k, float* X, int j) {
  float sum = X[k * n + j];
  for (int i = k + 1; i < n; ++i) sum += A[i * n + k] * X[i * n + j];
  sum *= tau;
  X[k * n + j] -= sum;
  for (int i = k + 1; i < n; ++i) X[i * n + j] -= A[i * n + k] * sum;
}

/// Overwrites A and tau, (n), and fills Q; matrices are row-major.
template <class Team>
ELASTOGEN_HD inline void orthonormal_basis(const Team& team, int n, float* A, float* tau,
                                           float* Q) {
  for (int k = 0; k < n; ++k) {
    const Reflection r = reflection(A, n, k);
    team.sync();  // all threads have read column k
    for (int i = k + 1 + team.lane; i < n; i += team.lanes) A[i * n + k] *= r.scale;
    if (team.lane == 0) tau[k] = r.tau;
    team.sync();
    for (int j = k + 1 + team.lane; j < n; j += team.lanes) reflect(A, r.tau, n, k, A, j);
    team.sync();
  }
  // Q = H_0 H_1 ... H_{n-1}; each thread computes some columns
  for (int j = team.lane; j < n; j += team.lanes) {
    for (int i = 0; i < n; ++i) Q[i * n + j] = i == j ? 1.f : 0.f;
    for (int k = n - 1; k >= 0; --k) reflect(A, tau[k], n, k, Q, j);
  }
  team.sync();
}

}  // namespace elastogen::householder
