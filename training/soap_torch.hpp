// SPDX-License-Identifier: Apache-2.0
// SOAP (Vyas et al. 2024, arXiv 2409.11321): Adam in the eigenbasis of Shampoo's preconditioners,
// for a batch of matrices W at once. With the gradient G:
//
//   L <- s L + (1 - s) G G^T,   R <- s R + (1 - s) G^T G,   bases Q_L, Q_R of their eigenvectors
//   M <- s M + (1 - s) G,       V <- s V + (1 - s) (Q_L^T G Q_R)^2
//   W <- W - rate Q_L [ (Q_L^T M Q_R) / sqrt V ] Q_R^T
//
// M and V are divided by 1 - s^step, the sum of their weights so far. Every ten steps one power
// iteration refreshes the bases.

#pragma once

#include <ATen/core/Tensor.h>

#include <array>

namespace elastogen {

class Soap {
 public:
  /// For matrices of shape (batch, rows, columns).
  Soap(int64_t batch, int64_t rows, int64_t columns, at::Device device);

  /// The update to subtract from the matrices; steps are counted from 1.
  at::Tensor update(const at::Tensor& G, double rate, int64_t step);

  /// All numbers that decide the next updates.
  std::array<at::Tensor*, 6> state() { return {&L_, &R_, &QL_, &QR_, &M_, &V_}; }

 private:
  at::Tensor L_, R_, QL_, QR_, M_, V_;
};

}  // namespace elastogen
