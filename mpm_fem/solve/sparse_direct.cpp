// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/solve/sparse_direct.hpp"

#include "core/error.hpp"
#include "mpm_fem/solve/blas_threads.hpp"

#include <cholmod.h>

#include <algorithm>

namespace elastogen::fem {

struct SparseDirect::Impl {
  cholmod_common common;
  cholmod_factor* factor = nullptr;
  cholmod_dense *x = nullptr, *y = nullptr, *e = nullptr;  // workspace of solve
  int64_t rows = 0;
  bool factored = false;

  Impl() { cholmod_start(&common); }
  ~Impl() {
    for (cholmod_dense** work : {&x, &y, &e}) cholmod_free_dense(work, &common);
    cholmod_free_factor(&factor, &common);
    cholmod_finish(&common);
  }
  void check_memory(const char* what) const {
    if (common.status == CHOLMOD_OUT_OF_MEMORY || common.status == CHOLMOD_TOO_LARGE)
      throw Error(concat(what, " of a matrix of ", rows, " rows does not fit into memory"),
                  ErrorKind::kResources);
  }
};

namespace {

/// Rows of a symmetric matrix as columns; CHOLMOD reads the lower triangle.
cholmod_sparse view(const SparseMatrix& A) {
  cholmod_sparse result{};
  result.nrow = result.ncol = size_t(A.rows());
  result.nzmax = size_t(A.entries());
  result.p = const_cast<int32_t*>(A.start.data());
  result.i = const_cast<int32_t*>(A.column.data());
  result.x = const_cast<double*>(A.value.data());
  result.stype = -1;
  result.itype = CHOLMOD_INT;
  result.xtype = CHOLMOD_REAL;
  result.dtype = CHOLMOD_DOUBLE;
  result.sorted = result.packed = 1;
  return result;
}

}  // namespace

SparseDirect::SparseDirect(const SparseMatrix& pattern) : impl_(std::make_unique<Impl>()) {
  hold_blas_threads();
  cholmod_common& c = impl_->common;
  c.print = 0;
  c.supernodal = CHOLMOD_SUPERNODAL;
  c.quick_return_if_not_posdef = 1;
  impl_->rows = pattern.rows();
  cholmod_sparse A = view(pattern);
  impl_->factor = cholmod_analyze(&A, &c);
  impl_->check_memory("the analysis");
}

SparseDirect::~SparseDirect() = default;

double SparseDirect::entries() const {
  return double(impl_->factor->xsize);
}

double SparseDirect::operations() const {
  return impl_->common.fl;
}

bool SparseDirect::factor(const SparseMatrix& matrix) {
  Impl& s = *impl_;
  ELASTOGEN_CHECK(matrix.rows() == s.rows, "the matrix must have ", s.rows, " rows, got ",
                  matrix.rows());
  cholmod_sparse A = view(matrix);
  cholmod_factorize(&A, s.factor, &s.common);
  s.check_memory("the factor");
  s.factored = s.common.status == CHOLMOD_OK && s.factor->minor == s.factor->n;
  return s.factored;
}

void SparseDirect::solve(const double* b, double* x) {
  Impl& s = *impl_;
  ELASTOGEN_CHECK(s.factored, "solve needs a matrix that was factored");
  cholmod_dense right{};
  right.nrow = right.nzmax = right.d = size_t(s.rows);
  right.ncol = 1;
  right.x = const_cast<double*>(b);
  right.xtype = CHOLMOD_REAL;
  right.dtype = CHOLMOD_DOUBLE;
  cholmod_solve2(CHOLMOD_A, s.factor, &right, nullptr, &s.x, nullptr, &s.y, &s.e, &s.common);
  s.check_memory("the solution");
  const double* result = static_cast<const double*>(s.x->x);
  std::copy(result, result + s.rows, x);
}

}  // namespace elastogen::fem
