// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/solve/sparse_lu.hpp"

#include "core/error.hpp"
#include "core/reduce.hpp"
#include "mpm_fem/solve/blas_threads.hpp"

#include <umfpack.h>

namespace elastogen::fem {

// UMFPACK reads columns. Our rows are the columns of A^T: it factors A^T and solves with its
// transpose
struct SparseLu::Impl {
  double control[UMFPACK_CONTROL], info[UMFPACK_INFO];
  void *symbolic = nullptr, *numeric = nullptr;
  int64_t rows = 0;
  double operations = 0;
  const SparseMatrix* matrix = nullptr;  // the one that is factored

  Impl() { umfpack_di_defaults(control); }
  ~Impl() {
    umfpack_di_free_numeric(&numeric);
    umfpack_di_free_symbolic(&symbolic);
  }
  void check_memory(int status, const char* what) const {
    if (status == UMFPACK_ERROR_out_of_memory)
      throw Error(concat(what, " of a matrix of ", rows, " rows does not fit into memory"),
                  ErrorKind::kResources);
  }
};

SparseLu::SparseLu(const SparseMatrix& pattern) : impl_(std::make_unique<Impl>()) {
  hold_blas_threads();
  Impl& s = *impl_;
  s.rows = pattern.rows();
  if (s.rows == 0) return;
  const int n = int(s.rows);
  const int status = umfpack_di_symbolic(n, n, pattern.start.data(), pattern.column.data(), nullptr,
                                         &s.symbolic, s.control, s.info);
  s.check_memory(status, "the analysis");
  s.operations = s.info[UMFPACK_FLOPS_ESTIMATE];
}

SparseLu::~SparseLu() = default;

double SparseLu::operations() const {
  return impl_->operations;
}

bool SparseLu::factor(const SparseMatrix& A) {
  Impl& s = *impl_;
  ELASTOGEN_CHECK(A.rows() == s.rows, "the matrix must have ", s.rows, " rows, got ", A.rows());
  s.matrix = nullptr;
  umfpack_di_free_numeric(&s.numeric);
  if (!all_finite(A.value.data(), A.entries())) return false;
  if (s.rows > 0) {
    const int status = umfpack_di_numeric(A.start.data(), A.column.data(), A.value.data(),
                                          s.symbolic, &s.numeric, s.control, s.info);
    s.check_memory(status, "the factor");
    if (status != UMFPACK_OK) return false;
  }
  s.matrix = &A;
  return true;
}

void SparseLu::solve(const double* b, double* x) {
  Impl& s = *impl_;
  ELASTOGEN_CHECK(s.matrix, "solve needs a matrix that was factored");
  if (s.rows == 0) return;
  const SparseMatrix& A = *s.matrix;
  const int status = umfpack_di_solve(UMFPACK_At, A.start.data(), A.column.data(), A.value.data(),
                                      x, b, s.numeric, s.control, s.info);
  s.check_memory(status, "the solution");
}

}  // namespace elastogen::fem
