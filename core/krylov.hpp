// SPDX-License-Identifier: Apache-2.0
// Restarted GMRES (Saad, Schultz 1986) on function objects, for matrices that need not be
// symmetric. The preconditioner is on the right, A M^-1 (M x) = b, so that the residual is that of
// A x = b itself.

#pragma once

#include "core/arnoldi.hpp"

namespace elastogen {

/// kBreakdown: a cycle did not improve the solution, because A or M^-1 is singular or gives numbers
/// that are not finite, or because rounding exceeds the tolerance.
enum class KrylovStop : uint8_t { kConverged, kIterations, kBreakdown };

struct KrylovResult {
  KrylovStop stop = KrylovStop::kConverged;
  int iterations = 0;
  double residual = 0;  ///< |b - A x| / |b|
};

namespace krylov {

/// x += M^-1 V y with H y = g of the first `columns` columns, those without a pivot left out.
template <class T, class Precondition>
void add_solution(int columns, int64_t size, T* x, GmresWork<T>& work,
                  const Precondition& precondition) {
  const auto h = [&](int row, int col) {
    return work.H[size_t(col) * size_t(work.restart + 1) + size_t(row)];
  };
  while (columns > 0 && h(columns - 1, columns - 1) == 0) --columns;
  std::vector<double>& y = work.g;
  for (int k = columns - 1; k >= 0; --k) {
    for (int l = k + 1; l < columns; ++l) y[size_t(k)] -= h(k, l) * y[size_t(l)];
    y[size_t(k)] /= h(k, k);
  }
  std::fill(work.u.begin(), work.u.end(), T(0));
  for (int k = 0; k < columns; ++k)
    add_scaled(T(y[size_t(k)]), work.basis.data() + k * size, work.u.data(), size);
  precondition(work.u.data(), work.z.data());
  add_scaled(T(1), work.z.data(), x, size);
}

/// One cycle from the residual in v_0, whose norm is `residual`, to `goal`. Returns its iterations.
template <class T, class Product, class Precondition>
int cycle(T* x, int64_t size, double residual, double goal, int most, GmresWork<T>& work,
          const Product& product, const Precondition& precondition) {
  T* v = work.basis.data();
  for_each(size, [&](int64_t i) { v[i] = T(v[i] / residual); });
  std::fill(work.g.begin(), work.g.end(), 0.0);
  work.g[0] = residual;
  int j = 0;
  bool extended = true;
  while (extended && j < std::min(most, work.restart) && std::abs(work.g[size_t(j)]) > goal) {
    extended = extend(j, size, work, product, precondition);
    rotate(j, work);
    ++j;
  }
  add_solution(j, size, x, work, precondition);
  return j;
}

}  // namespace krylov

/// Solves A x = b from x = 0 to |b - A x| <= tolerance |b|.
/// @param product       writes A p
/// @param precondition  writes M^-1 r
template <class T, class Product, class Precondition>
KrylovResult gmres(const T* b, T* x, int64_t size, double tolerance, int max_iterations,
                   GmresWork<T>& work, const Product& product, const Precondition& precondition) {
  constexpr double kLeastGain = 1e-3;  // of a cycle that may be followed by another
  const double start = norm(b, size);
  T* r = work.basis.data();
  // x = 0, and b is the residual
  for_each(size, [&](int64_t i) { x[i] = 0, r[i] = b[i]; });
  KrylovResult result;
  result.residual = start == 0 ? 0 : 1;
  double before = std::numeric_limits<double>::infinity();
  while (!(result.residual <= tolerance)) {
    // another cycle, unless the last one gained too little
    result.stop = KrylovStop::kIterations;
    if (result.iterations >= max_iterations) return result;
    result.stop = KrylovStop::kBreakdown;
    if (!(result.residual <= (1 - kLeastGain) * before)) return result;
    before = result.residual;
    result.iterations +=
        krylov::cycle(x, size, before * start, tolerance * start,
                      max_iterations - result.iterations, work, product, precondition);
    // the true residual
    product(x, r);
    for_each(size, [&](int64_t i) { r[i] = b[i] - r[i]; });
    result.residual = norm(r, size) / start;
  }
  result.stop = KrylovStop::kConverged;
  return result;
}

}  // namespace elastogen
