// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/solve/linear_solver.hpp"

#include "core/error.hpp"
#include "core/mat3.hpp"

#include <algorithm>

namespace elastogen::fem {

LinearSolver::LinearSolver(const SparseMatrix& pattern, In<double> positions, const uint8_t* fixed,
                           const LinearOptions& options)
    : options_(options) {
  reset(pattern, positions, fixed);
}

void LinearSolver::reset(const SparseMatrix& pattern, In<double> positions, const uint8_t* fixed) {
  ++analyses_;
  rows_ = pattern.rows();
  entries_ = pattern.entries();
  matrix_ = nullptr;
  coarse_.reset();
  direct_.reset();
  if (entries_ <= options_.max_entries) direct_ = std::make_unique<SparseDirect>(pattern);
  if (direct_ && direct_->operations() <= options_.max_operations) return;
  direct_.reset();
  coarse_ = std::make_unique<CoarseSpace>(pattern, positions, fixed);
  inverse_.resize(size_t(3 * pattern.rows()));
  work_ = PcgWork<double>(pattern.rows());
}

/// False where a block is not positive definite.
bool LinearSolver::invert_blocks() {
  std::vector<uint8_t> definite(inverse_.size() / 9);
  for_each(int64_t(definite.size()), [&](int64_t n) {
    Mat3<double> B;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) B(i, j) = matrix_->at(3 * n + i, 3 * n + j);
    const double minor = B(0, 0) * B(1, 1) - B(0, 1) * B(1, 0), det = determinant(B);
    definite[size_t(n)] = B(0, 0) > 0 && minor > 0 && det > 0;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
        const double cofactor = B(i1, j1) * B(i2, j2) - B(i1, j2) * B(i2, j1);
        inverse_[size_t(9 * n + 3 * i + j)] = cofactor / det;  // B is symmetric
      }
  });
  return std::all_of(definite.begin(), definite.end(), [](uint8_t d) { return d != 0; });
}

bool LinearSolver::factor(const SparseMatrix& A) {
  ELASTOGEN_CHECK(A.rows() == rows_ && A.entries() == entries_,
                  "the matrix must have the pattern that was analysed");
  matrix_ = &A;
  if (direct_) return direct_->factor(A);
  return invert_blocks() && coarse_->factor(A);
}

bool LinearSolver::solve(const double* b, double* x, double tolerance) {
  if (direct_) {
    direct_->solve(b, x);
    return true;
  }
  const auto precondition = [&](const double* r, double* z) {
    for_each(int64_t(inverse_.size() / 9), [&](int64_t n) {
      for (int i = 0; i < 3; ++i) {
        const double* row = inverse_.data() + 9 * n + 3 * i;
        z[3 * n + i] = row[0] * r[3 * n] + row[1] * r[3 * n + 1] + row[2] * r[3 * n + 2];
      }
    });
    coarse_->add_correction(r, z);
  };
  const PcgResult result = pcg(
      b, x, matrix_->rows(), tolerance, options_.max_iterations, work_,
      [&](const double* p, double* Ap) { multiply(*matrix_, p, Ap); }, precondition);
  iterations_ += result.iterations;
  return result.converged || result.iterations == options_.max_iterations;
}

}  // namespace elastogen::fem
