// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/solve/nonsymmetric_solver.hpp"

#include "core/error.hpp"
#include "core/mat3.hpp"

#include <algorithm>

namespace elastogen::fem {

void NonsymmetricSolver::reset(const SparseMatrix& pattern) {
  rows_ = pattern.rows();
  entries_ = pattern.entries();
  matrix_ = nullptr;
  direct_.reset();
  if (entries_ <= options_.max_entries) direct_ = std::make_unique<SparseLu>(pattern);
  if (direct_ && direct_->operations() <= options_.max_operations) return;
  direct_.reset();
  inverse_.resize(size_t(3 * rows_));
  work_ = GmresWork<double>(rows_);
}

/// False where a block is singular or not finite.
bool NonsymmetricSolver::invert_blocks() {
  std::vector<uint8_t> regular(inverse_.size() / 9);
  for_each(int64_t(regular.size()), [&](int64_t n) {
    Mat3<double> B;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) B(i, j) = matrix_->at(3 * n + i, 3 * n + j);
    const Mat3<double> C = cofactor(B);
    const double det = determinant(B);
    regular[size_t(n)] = det != 0 && std::isfinite(det);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) inverse_[size_t(9 * n + 3 * i + j)] = C(j, i) / det;
  });
  return std::all_of(regular.begin(), regular.end(), [](uint8_t r) { return r != 0; });
}

void NonsymmetricSolver::apply_blocks(const double* r, double* z) const {
  for_each(int64_t(inverse_.size() / 9), [&](int64_t n) {
    for (int i = 0; i < 3; ++i) {
      const double* row = inverse_.data() + 9 * n + 3 * i;
      z[3 * n + i] = row[0] * r[3 * n] + row[1] * r[3 * n + 1] + row[2] * r[3 * n + 2];
    }
  });
}

bool NonsymmetricSolver::factor(const SparseMatrix& A) {
  ELASTOGEN_CHECK(A.rows() == rows_ && A.entries() == entries_,
                  "the matrix must have the pattern that was analysed");
  matrix_ = &A;
  return direct_ ? direct_->factor(A) : invert_blocks();
}

bool NonsymmetricSolver::solve(const double* b, double* x, double tolerance) {
  if (direct_) {
    direct_->solve(b, x);
    return true;
  }
  const KrylovResult result = gmres(
      b, x, rows_, tolerance, options_.max_iterations, work_,
      [&](const double* p, double* Ap) { multiply(*matrix_, p, Ap); },
      [&](const double* r, double* z) { apply_blocks(r, z); });
  iterations_ += result.iterations;
  return result.stop != KrylovStop::kBreakdown;
}

}  // namespace elastogen::fem
