// SPDX-License-Identifier: Apache-2.0
// Preconditioned conjugate gradients on function objects.

#pragma once

#include "core/reduce.hpp"
#include "core/trust_region.hpp"

#include <vector>

namespace elastogen {

struct PcgResult {
  int iterations = 0;
  double residual = 0;  ///< |b - A x| / |b| as the recurrence has it
  bool converged = false;
  PcgScalars end = {};
};

/// Vectors of a solve, kept between calls.
template <class T>
struct PcgWork {
  std::vector<T> r, z, p, Ap;
  explicit PcgWork(int64_t size) : r(size_t(size)), z(r), p(r), Ap(r) {}
};

/// Solves A x = b from x = 0 to |b - A x| <= tolerance |b|, or to the edge of the radius of
/// `scalars`. Without a radius the symmetric A must be positive definite. Where rounding makes its
/// curvature negative, or stop() returns true, the present x is returned.
template <class T, class Product, class Precondition, class Stop>
PcgResult pcg(const T* b, T* x, int64_t size, double tolerance, int max_iterations,
              PcgWork<T>& work, const Product& product, const Precondition& precondition,
              const Stop& stop, PcgScalars scalars = {}) {
  // no structured binding: clang 14 cannot capture one
  std::vector<T>&r = work.r, &z = work.z, &p = work.p, &Ap = work.Ap;
  for_each(size, [&](int64_t k) { x[k] = 0, r[size_t(k)] = b[k]; });
  const double start = norm(b, size);
  PcgResult result;
  result.residual = start > 0 ? 1 : 0;
  while (result.residual > tolerance && result.iterations < max_iterations && !scalars.ended &&
         !stop()) {
    precondition(r.data(), z.data());
    scalars.turn(dot(r.data(), z.data(), size));
    const T beta = T(scalars.beta);
    for_each(size, [&](int64_t k) { p[size_t(k)] = z[size_t(k)] + beta * p[size_t(k)]; });
    product(p.data(), Ap.data());
    scalars.advance(dot(p.data(), Ap.data(), size));
    if (scalars.alpha == 0) break;
    const T alpha = T(scalars.alpha);
    add_scaled(alpha, p.data(), x, size);
    add_scaled(T(-alpha), Ap.data(), r.data(), size);
    result.residual = norm(r.data(), size) / start;
    ++result.iterations;
  }
  result.end = scalars;
  result.converged = result.residual <= tolerance;
  return result;
}

/// pcg without stop().
template <class T, class Product, class Precondition>
PcgResult pcg(const T* b, T* x, int64_t size, double tolerance, int max_iterations,
              PcgWork<T>& work, const Product& product, const Precondition& precondition) {
  return pcg(b, x, size, tolerance, max_iterations, work, product, precondition,
             [] { return false; });
}

}  // namespace elastogen
