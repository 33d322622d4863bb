// SPDX-License-Identifier: Apache-2.0
// Arnoldi's orthonormal basis of a Krylov space and the matrix projected on it, which rotations
// keep triangular as it grows: the parts of GMRES (core/krylov.hpp).

#pragma once

#include "core/reduce.hpp"

#include <cmath>
#include <limits>
#include <vector>

namespace elastogen {

/// Vectors of a solve, kept between calls.
template <class T>
struct GmresWork {
  int restart;            ///< iterations of a cycle
  std::vector<T> basis;   ///< of the Krylov space, (restart + 1, size)
  std::vector<T> z, u;    ///< M^-1 v, and a sum of basis vectors
  std::vector<double> H;  ///< of the projected A, columns made triangular, (restart, restart + 1)
  std::vector<double> g, c, s;  ///< the projected right-hand side; cosines and sines of rotations

  explicit GmresWork(int64_t size, int restart_after = 30)
      : restart(restart_after),
        basis(size_t(size * (restart_after + 1))),
        z(size_t(size)),
        u(z),
        H(size_t(restart_after * (restart_after + 1))),
        g(size_t(restart_after) + 1),
        c(size_t(restart_after)),
        s(c) {}
};

namespace krylov {

/// Adds a column to H: A M^-1 v_j is made orthogonal to the basis and extends it. False: it lies in
/// the space of the basis.
template <class T, class Product, class Precondition>
bool extend(int j, int64_t size, GmresWork<T>& work, const Product& product,
            const Precondition& precondition) {
  const auto v = [&](int k) { return work.basis.data() + k * size; };
  double* h = work.H.data() + size_t(j) * size_t(work.restart + 1);
  T* w = v(j + 1);
  precondition(v(j), work.z.data());
  product(work.z.data(), w);
  const double before = norm(w, size);
  for (int k = 0; k <= j; ++k) {
    h[k] = dot(w, v(k), size);
    add_scaled(T(-h[k]), v(k), w, size);
  }
  h[j + 1] = norm(w, size);
  if (!(h[j + 1] > before * std::numeric_limits<T>::epsilon())) {
    h[j + 1] = 0;
    return false;
  }
  for_each(size, [&](int64_t i) { w[i] = T(w[i] / h[j + 1]); });
  return true;
}

/// Rotates the new column of H, so that H is triangular, and g with it; a pivot within rounding
/// becomes 0.
template <class T>
void rotate(int j, GmresWork<T>& work) {
  double* h = work.H.data() + size_t(j) * size_t(work.restart + 1);
  std::vector<double>&c = work.c, &s = work.s, &g = work.g;
  const double least = std::numeric_limits<T>::epsilon() * std::sqrt(dot(h, h, j + 2));
  for (int k = 0; k < j; ++k) {
    const double upper = h[k];
    h[k] = c[size_t(k)] * upper + s[size_t(k)] * h[k + 1];
    h[k + 1] = c[size_t(k)] * h[k + 1] - s[size_t(k)] * upper;
  }
  const double length = std::hypot(h[j], h[j + 1]);
  c[size_t(j)] = length > 0 ? h[j] / length : 1;
  s[size_t(j)] = length > 0 ? h[j + 1] / length : 0;
  h[j] = length > least ? length : 0;
  g[size_t(j) + 1] = -s[size_t(j)] * g[size_t(j)];
  g[size_t(j)] *= c[size_t(j)];
}

}  // namespace krylov

}  // namespace elastogen
