// SPDX-License-Identifier: Apache-2.0
// NeuralMTL, the learned material law (ElastoGen, Eq. 4-7): one net of 17153 weights, evaluated
// once for each axis,
//
//     psi_theta = omega/2 sum_i (sigma_i n_i - 1)^2 = omega/2 sum_i q_i^2,     omega = 3K,
//     q_i = (a+b) e_i + b (e_j + e_k) + f(x_i) - f(0) - f_0 e_i - f_1 (e_j + e_k),   e = ln sigma,
//     x_i = (e_i, e_j + e_k, e_j e_k),   a = sqrt(2 mu/omega),   b = (1 - a)/3,
//
// with f_0, f_1 the derivatives of f at 0 in its first two inputs.
//
// The inputs are symmetric in j and k, so the law is exactly isotropic. The subtracted terms of f
// make psi = 0, t = 0 and H = 2 mu I + lambda 1 1^T at rest exact for any weights. The slope in e_j
// e_k is not subtracted: it is of second order in e, changes none of the three, and without it q
// could not have such a term (docs/papers.md).
// Stress and Hessian are the exact derivatives, by jets through the net. Energies in units of E.

#pragma once

#include "core/array.hpp"
#include "network/law/neural_mtl_impl.hpp"

#include <span>
#include <vector>

namespace elastogen {

/// Name of this formula of psi_theta in model cards; weights for another one cannot be used.
inline constexpr const char* kMtlForm = "log stretches 2";

class NeuralMtl {
 public:
  static constexpr int kWidth = 128;
  static constexpr int64_t kParameters = 17153;

  /// @param weights  W1 (128, 3), b1, W2 (128, 128), b2, w3 (128), b3, row-major, one after
  /// another.
  /// @param poisson  ratio that they were fitted for; gives a and b.
  /// @throws Error (asset) unless there are 17153 finite weights and 0 <= poisson < 0.5.
  NeuralMtl(std::span<const float> weights, double poisson);

  double mu() const { return mu_; }          ///< over E
  double lambda() const { return lambda_; }  ///< over E
  const MtlTerms& terms() const { return terms_; }

  /// Strains q_i, (n, 3), at log stretches e, (n, 3).
  void strains(const double* e, int64_t n, double* q) const;
  /// psi and first derivatives, with kHessian second ones too, at log stretches e, (n, 3).
  template <bool kHessian>
  void evaluate(const double* e, int64_t n, LogJet* result) const;
  /// psi alone.
  void evaluate(const double* e, int64_t n, double* psi) const;

 private:
  template <int kChannels>
  void jets(const double* x, int count, double* f) const;

  double mu_, lambda_;
  std::vector<double> w1_, b1_, w2_, b2_, w3_;  // w1_ column-major, w2_ row-major
  double b3_ = 0;
  MtlTerms terms_;
};

}  // namespace elastogen
