// SPDX-License-Identifier: Apache-2.0
#include "training/orthonormal_basis.hpp"

#include "training/orthonormal_basis_impl.hpp"
#include "training/strain_sampler.hpp"

#include <gtest/gtest.h>

#include <barrier>
#include <thread>
#include <vector>

namespace elastogen {
namespace {

/// Numbers in -1 ... 1; column j times scale^j.
std::vector<float> random_matrix(int n, double scale) {
  std::vector<float> A;
  for (int k = 0; k < n * n; ++k)
    A.push_back(float((2 * counted_uniform(1, uint64_t(k), 0) - 1) * std::pow(scale, k % n)));
  return A;
}

std::vector<float> basis_of(int n, const std::vector<float>& A) {
  std::vector<float> Q(A.size());
  cpu::orthonormal_bases(1, n, A.data(), Q.data());
  return Q;
}

/// (X^T Y)_ij
double product(int n, const std::vector<float>& X, const std::vector<float>& Y, int i, int j) {
  double sum = 0;
  for (int k = 0; k < n; ++k) sum += double(X[size_t(k * n + i)]) * Y[size_t(k * n + j)];
  return sum;
}

void expect_basis(int n, const std::vector<float>& A) {
  const std::vector<float> Q = basis_of(n, A);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      EXPECT_NEAR(product(n, Q, Q, i, j), i == j ? 1 : 0, 3e-6);
      // R = Q^T A has nothing below its diagonal
      if (i <= j) continue;
      EXPECT_NEAR(product(n, Q, A, i, j), 0, 3e-6 * std::sqrt(product(n, A, A, j, j)));
    }
}

TEST(OrthonormalBasis, SpansColumnAfterColumn) {
  for (const int n : {1, 2, 5, 32}) expect_basis(n, random_matrix(n, 1));
}

TEST(OrthonormalBasis, HoldsWhereColumnsFallOverManyOrders) {
  expect_basis(32, random_matrix(32, 0.5));
}

TEST(OrthonormalBasis, IsABasisAlsoOfMatricesWithoutFullRank) {
  expect_basis(4, std::vector<float>(16, 0));
  std::vector<float> A = random_matrix(8, 1);
  for (int i = 0; i < 8; ++i) A[size_t(8 * i + 3)] = A[size_t(8 * i + 1)];
  expect_basis(8, A);
}

TEST(OrthonormalBasis, TakesManyMatrices) {
  std::vector<float> A = random_matrix(6, 1), two = A;
  two.insert(two.end(), A.rbegin(), A.rend());
  std::vector<float> Q(two.size());
  cpu::orthonormal_bases(2, 6, two.data(), Q.data());
  EXPECT_EQ(std::vector<float>(Q.begin(), Q.begin() + 36), basis_of(6, A));
  EXPECT_EQ(std::vector<float>(Q.begin() + 36, Q.end()),
            basis_of(6, std::vector<float>(A.rbegin(), A.rend())));
}

/// A team of threads of the host, as a block of the GPU is one.
struct Threads {
  int lane, lanes;
  std::barrier<>* barrier;
  void sync() const { barrier->arrive_and_wait(); }
};

TEST(OrthonormalBasis, IsTheSameBitByBitForATeam) {
  constexpr int n = 21, lanes = 4;
  const std::vector<float> A = random_matrix(n, 0.7);
  std::vector<float> work = A, tau(n), Q(A.size());
  std::barrier barrier(lanes);
  std::vector<std::thread> threads;
  for (int lane = 0; lane < lanes; ++lane)
    threads.emplace_back([&, lane] {
      householder::orthonormal_basis(Threads{lane, lanes, &barrier}, n, work.data(), tau.data(),
                                     Q.data());
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(Q, basis_of(n, A));
}

}  // namespace
}  // namespace elastogen
