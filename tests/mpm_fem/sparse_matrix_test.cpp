// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/solve/sparse_matrix.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "mpm_fem/solve/assembly.hpp"
#include "mpm_fem/solve/sparse_direct.hpp"
#include "tests/mpm_fem/bodies.hpp"

#include <Eigen/Dense>
#include <Eigen/SparseCholesky>
#include <gtest/gtest.h>

#include <random>

namespace elastogen::fem {
namespace {

using Dense = Eigen::MatrixXd;

Array<int32_t> hexahedra(int nx, int ny, int nz) {
  return test::block(Element::kHex, nx, ny, nz, 1).elements;
}

int64_t node_count(const Array<int32_t>& elements) {
  int32_t last = 0;
  for (int64_t k = 0; k < elements.size(); ++k) last = std::max(last, elements.data()[k]);
  return last + 1;
}

/// Random symmetric matrices, one an element; B B^T + shift I.
Dense element_matrix(int64_t element, int corners, double shift) {
  std::mt19937 random{static_cast<uint32_t>(element)};
  std::normal_distribution<double> normal;
  Dense B(3 * corners, 3 * corners);
  for (double& b : B.reshaped()) b = normal(random);
  return B * B.transpose() + shift * Dense::Identity(B.rows(), B.rows());
}

SparseMatrix assembled(const Array<int32_t>& elements, double shift) {
  Assembly assembly(stencils_of(elements), node_count(elements));
  SparseMatrix A = pattern_of(assembly.stencils(), node_count(elements));
  assembly.fit(A);
  assembly.add(
      [&](int64_t e, double* K) {
        const Dense matrix = element_matrix(e, elements.cols(), shift);
        std::copy(matrix.data(), matrix.data() + matrix.size(), K);
      },
      A);
  return A;
}

Dense to_dense(const SparseMatrix& A) {
  Dense result = Dense::Zero(A.rows(), A.rows());
  for (int64_t r = 0; r < A.rows(); ++r)
    for (int32_t k = A.start[size_t(r)]; k < A.start[size_t(r) + 1]; ++k)
      result(r, A.column[size_t(k)]) = A.value[size_t(k)];
  return result;
}

TEST(SparseMatrix, IsTheSumOfTheElementMatrices) {
  const Array<int32_t> elements = hexahedra(3, 2, 2);
  Dense expected = Dense::Zero(3 * node_count(elements), 3 * node_count(elements));
  for (int64_t e = 0; e < elements.rows(); ++e) {
    const Dense K = element_matrix(e, 8, 0);
    for (int a = 0; a < 24; ++a)
      for (int b = 0; b < 24; ++b)
        expected(3 * elements(e, a / 3) + a % 3, 3 * elements(e, b / 3) + b % 3) += K(a, b);
  }
  const SparseMatrix A = assembled(elements, 0);
  EXPECT_LT((to_dense(A) - expected).norm(), 1e-14 * expected.norm());

  const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(A.rows(), -1, 2);
  Eigen::VectorXd y(A.rows());
  multiply(A, x.data(), y.data());
  EXPECT_LT((y - expected * x).norm(), 1e-14 * expected.norm() * x.norm());
  EXPECT_EQ(diagonal(A)[5], A.at(5, 5));
}

TEST(SparseMatrix, HasTheSameBitsOnAnyNumberOfThreads) {
  const Array<int32_t> elements = hexahedra(12, 7, 5);
  const SparseMatrix many = assembled(elements, 0);
  const ThreadLimit limit(1);
  EXPECT_EQ(many.value, assembled(elements, 0).value);
}

TEST(SparseMatrix, FixedUnknownsTakeTheirValues) {
  SparseMatrix A = assembled(hexahedra(2, 2, 1), 1);
  const Dense full = to_dense(A);
  std::vector<uint8_t> fixed(size_t(A.rows()));
  Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(A.rows(), 1, 3), b = full * x;
  for (size_t k = 0; k < fixed.size(); ++k) fixed[k] = k % 5 == 0 || k > 30;
  const SparseMatrix part = free_part(fixed.data(), A);
  for (size_t k = 0; k < fixed.size(); ++k)
    if (fixed[k]) b(Eigen::Index(k)) = x(Eigen::Index(k));
  fix_unknowns(fixed.data(), A, b.data());
  const Dense reduced = to_dense(A);
  EXPECT_EQ(reduced, Dense(reduced.transpose()));
  EXPECT_LT((reduced.ldlt().solve(b) - x).norm(), 1e-10 * x.norm());

  std::vector<Eigen::Index> kept;
  for (size_t k = 0; k < fixed.size(); ++k)
    if (!fixed[k]) kept.push_back(Eigen::Index(k));
  EXPECT_EQ(to_dense(part), full(kept, kept));
}

TEST(SparseMatrix, AddsAMatrixOfFewerEntries) {
  const Array<int32_t> elements = hexahedra(2, 1, 1);
  SparseMatrix A = assembled(elements, 0), B = pattern_of(stencils_of({elements.data(), 1, 8}), 12);
  for (size_t k = 0; k < B.value.size(); ++k) B.value[k] = double(k);
  const Dense expected = to_dense(A) + 2 * to_dense(B);
  add_multiple(2, B, A);
  EXPECT_EQ(to_dense(A), expected);
}

TEST(SparseMatrix, PatternCouplesStencilsOfAnyLength) {
  // stencils of 27, 2, 1 and no nodes
  Stencils stencils;
  std::vector<int32_t> many(27);
  for (int32_t k = 0; k < 27; ++k) many[size_t(k)] = k;
  stencils.add(many.data(), 27);
  const int32_t pair[2] = {26, 28}, alone = 29;
  stencils.add(pair, 2);
  stencils.add(&alone, 1);
  stencils.add(nullptr, 0);
  Assembly assembly(stencils, 30);
  SparseMatrix A = pattern_of(stencils, 30);
  EXPECT_EQ(A.entries(), 9 * (27 * 27 + 3 + 1 + 1));  // node 27 has itself only
  assembly.fit(A);
  // constant matrices, so that entries show which stencils they have
  assembly.add(
      [&](int64_t s, double* K) {
        const int64_t width = 3 * stencils.length(s);
        for (int64_t k = 0; k < width * width; ++k) K[k] = double(s + 1);
      },
      A);
  EXPECT_EQ(A.at(0, 80), 1);
  EXPECT_EQ(A.at(79, 78), 1 + 2);
  EXPECT_EQ(A.at(85, 79), 2);
  EXPECT_EQ(A.at(89, 87), 3);
  EXPECT_EQ(A.at(81, 81), 0);
}

TEST(SparseMatrix, RejectsWhatItsDocumentationForbids) {
  const Array<int32_t> elements = hexahedra(2, 1, 1);
  const Stencils stencils = stencils_of(elements), one = stencils_of(hexahedra(1, 1, 1));
  Assembly assembly(stencils, 12);
  SparseMatrix A = pattern_of(stencils, 12), smaller = pattern_of(one, 12);
  EXPECT_THROW(assembly.add([](int64_t, double*) {}, A), Error);  // not fitted yet
  EXPECT_THROW(assembly.fit(smaller), Error);
  assembly.fit(A);
  EXPECT_THROW(assembly.add([](int64_t, double*) {}, smaller), Error);
  EXPECT_THROW(A.at(0, 35), Error);
  const double block[9] = {};
  EXPECT_THROW(A.add_block(0, 11, block), Error);
  EXPECT_THROW(add_multiple(1, A, smaller), Error);
  EXPECT_THROW(add_multiple(1, pattern_of(one, 8), A), Error);
  EXPECT_THROW(pattern_of(stencils, 11), Error);
  EXPECT_THROW(Assembly(stencils, 11), Error);
}

TEST(SparseMatrix, TakesNoElements) {
  Assembly assembly(stencils_of(Array<int32_t>(0, 8)), 0);
  SparseMatrix A = pattern_of(assembly.stencils(), 0);
  assembly.fit(A);
  assembly.add([](int64_t, double*) {}, A);
  EXPECT_EQ(A.rows(), 0);
}

TEST(SparseDirect, SolvesAsEigenDoes) {
  const SparseMatrix A = assembled(hexahedra(6, 5, 4), 0.1);
  const Eigen::SparseMatrix<double> reference =
      Eigen::Map<const Eigen::SparseMatrix<double, Eigen::RowMajor>>(
          A.rows(), A.rows(), A.entries(), A.start.data(), A.column.data(), A.value.data());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> ldlt(reference);
  const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(A.rows(), -1, 1);
  const Eigen::VectorXd expected = ldlt.solve(b);
  SparseDirect direct(A);
  ASSERT_TRUE(direct.factor(A));
  Eigen::VectorXd x = b;
  direct.solve(x.data(), x.data());
  EXPECT_LT((x - expected).norm(), 1e-12 * expected.norm());
  EXPECT_LT((reference * x - b).norm(), 1e-12 * b.norm());
  EXPECT_GE(direct.entries(), double(A.entries() + A.rows()) / 2);
}

TEST(SparseDirect, SaysWhatIsNotPositiveDefiniteAndGoesOn) {
  SparseMatrix A = assembled(hexahedra(4, 4, 4), 1);
  SparseDirect direct(A);
  std::vector<double> b(size_t(A.rows()), 1), x(b);
  EXPECT_THROW(direct.solve(b.data(), x.data()), Error);
  SparseMatrix indefinite = A;
  indefinite.at(200, 200) = -1;
  EXPECT_FALSE(direct.factor(indefinite));
  EXPECT_THROW(direct.solve(b.data(), x.data()), Error);
  SparseMatrix singular = A;
  for (double& a : singular.value) a = 0;
  EXPECT_FALSE(direct.factor(singular));
  ASSERT_TRUE(direct.factor(A));
  direct.solve(b.data(), x.data());
  std::vector<double> Ax(x);
  multiply(A, x.data(), Ax.data());
  for (const double y : Ax) ASSERT_NEAR(y, 1, 1e-11);
}

TEST(SparseDirect, HasTheSameBitsOnAnyNumberOfThreads) {
  const SparseMatrix A = assembled(hexahedra(14, 10, 10), 1);
  const std::vector<double> b(size_t(A.rows()), 1);
  std::vector<double> x(b), again(b);
  SparseDirect direct(A), other(A);
  ASSERT_TRUE(direct.factor(A));
  direct.solve(b.data(), x.data());
  const ThreadLimit limit(1);
  ASSERT_TRUE(other.factor(A));
  other.solve(b.data(), again.data());
  EXPECT_EQ(x, again);
}

}  // namespace
}  // namespace elastogen::fem
