// SPDX-License-Identifier: Apache-2.0
#include "network/law/neural_mtl.hpp"

#include "core/error.hpp"

#include <Eigen/Core>

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

constexpr int kAxesAtOnce = 24;  // axes that are evaluated at once: eight strains

using Matrix = Eigen::Matrix<double, NeuralMtl::kWidth, Eigen::Dynamic>;
using Weights = Eigen::Matrix<double, NeuralMtl::kWidth, NeuralMtl::kWidth, Eigen::RowMajor>;

/// Jets through the activation; channel c is the block of columns c count ... (c+1) count - 1.
template <int kChannels>
void activate(Matrix& z, int count) {
  const auto channel = [&](int c) { return z.middleCols(c * count, count).array(); };
  const Eigen::ArrayXXd value = channel(0), sigmoid = 1 / (1 + (-value).exp());
  mtl::activate<kChannels>(mtl::silu(value, sigmoid), channel);
}

}  // namespace

NeuralMtl::NeuralMtl(std::span<const float> weights, double poisson) {
  ELASTOGEN_CHECK_ASSET(int64_t(weights.size()) == kParameters, "a NeuralMTL has ", kParameters,
                        " weights, not ", weights.size());
  ELASTOGEN_CHECK_ASSET(
      std::all_of(weights.begin(), weights.end(), [](float w) { return std::isfinite(w); }),
      "a weight of the NeuralMTL is not finite");
  ELASTOGEN_CHECK_ASSET(poisson >= 0 && poisson < 0.5, "a NeuralMTL needs 0 <= nu < 0.5, got ",
                        poisson);
  mu_ = 1 / (2 * (1 + poisson));
  lambda_ = poisson / ((1 + poisson) * (1 - 2 * poisson));
  // the layers, one after another; the first column by column
  const float* next = weights.data();
  const auto take = [&](std::vector<double>& to, int64_t count) {
    to.assign(next, next + count);
    next += count;
  };
  std::vector<double> first;
  take(first, kWidth * 3);
  for (int m = 0; m < 3; ++m)
    for (int k = 0; k < kWidth; ++k) w1_.push_back(first[size_t(3 * k + m)]);
  take(b1_, kWidth);
  take(w2_, kWidth * kWidth);
  take(b2_, kWidth);
  take(w3_, kWidth);
  b3_ = double(*next);
  // f and its slopes at rest, which strains subtract
  const double rest[3] = {};
  double jet[4];
  jets<4>(rest, 1, jet);
  terms_ = MtlTerms(mu_, lambda_);
  std::copy_n(jet, 3, terms_.f0);
}

/// f and its derivatives in x at inputs x, (count, 3), count <= kAxesAtOnce: f, (channels, count).
template <int kChannels>
void NeuralMtl::jets(const double* x, int count, double* f) const {
  const auto W1 = Eigen::Map<const Eigen::Matrix<double, kWidth, 3>>(w1_.data());
  const auto W2 = Eigen::Map<const Weights>(w2_.data());
  const auto b1 = Eigen::Map<const Eigen::VectorXd>(b1_.data(), kWidth);
  const auto b2 = Eigen::Map<const Eigen::VectorXd>(b2_.data(), kWidth);
  const auto w3 = Eigen::Map<const Eigen::RowVectorXd>(w3_.data(), kWidth);
  const auto X = Eigen::Map<const Eigen::Matrix<double, 3, Eigen::Dynamic>>(x, 3, count);

  Matrix z = Matrix::Zero(kWidth, kChannels * count);
  z.leftCols(count) = (W1 * X).colwise() + b1;
  if constexpr (kChannels >= 4)
    for (int m = 0; m < 3; ++m) z.middleCols((1 + m) * count, count).colwise() = W1.col(m);
  activate<kChannels>(z, count);
  Matrix next = W2 * z;
  next.leftCols(count).colwise() += b2;
  activate<kChannels>(next, count);
  auto result = Eigen::Map<Eigen::RowVectorXd>(f, kChannels * count);
  result.noalias() = w3 * next;
  result.head(count).array() += b3_;
}

namespace {

/// x_i of the three axes.
void inputs(const double e[3], double x[9]) {
  for (int i = 0; i < 3; ++i) mtl::inputs(e, i, x + 3 * i);
}

}  // namespace

void NeuralMtl::strains(const double* e, int64_t n, double* q) const {
  constexpr int kStrains = kAxesAtOnce / 3;
  for (int64_t begin = 0; begin < n; begin += kStrains) {
    const int count = int(std::min<int64_t>(kStrains, n - begin));
    double x[3 * kAxesAtOnce], f[kAxesAtOnce];
    for (int v = 0; v < count; ++v) inputs(e + 3 * (begin + v), x + 9 * v);
    jets<1>(x, 3 * count, f);
    for (int v = 0; v < count; ++v)
      for (int i = 0; i < 3; ++i) {
        const double of_axis[10] = {f[3 * v + i]};
        q[3 * (begin + v) + i] = mtl::strain<false>(e + 3 * (begin + v), i, of_axis, terms_).q;
      }
  }
}

void NeuralMtl::evaluate(const double* e, int64_t n, double* psi) const {
  std::vector<double> q(3 * size_t(n));
  strains(e, n, q.data());
  for (size_t k = 0; k < size_t(n); ++k)
    psi[k] = terms_.omega / 2 *
             (q[3 * k] * q[3 * k] + q[3 * k + 1] * q[3 * k + 1] + q[3 * k + 2] * q[3 * k + 2]);
}

template <bool kHessian>
void NeuralMtl::evaluate(const double* e, int64_t n, LogJet* result) const {
  constexpr int kChannels = kHessian ? 10 : 4, kStrains = kAxesAtOnce / 3;
  for (int64_t begin = 0; begin < n; begin += kStrains) {
    const int count = int(std::min<int64_t>(kStrains, n - begin));
    double x[3 * kAxesAtOnce], f[kChannels * kAxesAtOnce];
    for (int v = 0; v < count; ++v) inputs(e + 3 * (begin + v), x + 9 * v);
    jets<kChannels>(x, 3 * count, f);
    for (int v = 0; v < count; ++v) {
      mtl::Strain s[3];
      for (int i = 0; i < 3; ++i) {
        double of_axis[10] = {};
        for (int c = 0; c < kChannels; ++c) of_axis[c] = f[c * 3 * count + 3 * v + i];
        s[i] = mtl::strain<kHessian>(e + 3 * (begin + v), i, of_axis, terms_);
      }
      result[begin + v] = mtl::energy<kHessian>(s, terms_.omega);
    }
  }
}

template void NeuralMtl::evaluate<false>(const double*, int64_t, LogJet*) const;
template void NeuralMtl::evaluate<true>(const double*, int64_t, LogJet*) const;

}  // namespace elastogen
