// SPDX-License-Identifier: Apache-2.0
#include "network/neural_mtl.hpp"

#include "core/error.hpp"

#include <Eigen/Core>

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

constexpr int kAxesAtOnce = 24;  // axes that are evaluated at once: eight strains
constexpr int kEntryRow[6] = {0, 1, 2, 0, 1, 2},
              kEntryColumn[6] = {0, 1, 2, 1, 2, 0};  // channels 4..9

using Matrix = Eigen::Matrix<double, NeuralMtl::kWidth, Eigen::Dynamic>;
using Weights = Eigen::Matrix<double, NeuralMtl::kWidth, NeuralMtl::kWidth, Eigen::RowMajor>;

/// SiLU and its first two derivatives.
struct Silu {
  Eigen::ArrayXXd value, first, second;
};

Silu silu(const Eigen::Ref<const Eigen::ArrayXXd>& z) {
  const Eigen::ArrayXXd s = 1 / (1 + (-z).exp()), slope = s * (1 - s);
  return {z * s, s + z * slope, slope * (2 + z * (1 - 2 * s))};
}

/// Jets through the activation: a = act(z), a_m = act' z_m, a_mn = act'' z_m z_n + act' z_mn.
/// Channel c is the block of columns c count ... (c+1) count - 1.
template <int kChannels>
void activate(Matrix& z, int count) {
  const auto channel = [&](int c) { return z.middleCols(c * count, count).array(); };
  const Silu act = silu(channel(0));
  if constexpr (kChannels == 10)
    for (int c = 0; c < 6; ++c)
      channel(4 + c) = act.second * channel(1 + kEntryRow[c]) * channel(1 + kEntryColumn[c]) +
                       act.first * channel(4 + c);
  if constexpr (kChannels >= 4)
    for (int m = 0; m < 3; ++m) channel(1 + m) *= act.first;
  channel(0) = act.value;
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
  const double rest[3] = {};
  double jet[4];
  jets<4>(rest, 1, jet);
  std::copy_n(jet, 3, f0_);
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
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    x[3 * i] = e[i], x[3 * i + 1] = e[j] + e[k], x[3 * i + 2] = e[j] * e[k];
  }
}

/// q_i with its derivatives in e, from f and its derivatives in x_i, anchored.
struct Strain {
  double q, d[3], dd[6];
};

template <bool kHessian>
Strain strain(const double e[3], int i, const double f[10], const double f0[3], double a,
              double b) {
  const int j = (i + 1) % 3, k = (i + 2) % 3;
  const double fa = f[1] - f0[1] + a + b, fb = f[2] - f0[2] + b, fc = f[3];
  Strain s;
  s.q = (a + b) * e[i] + b * (e[j] + e[k]) + f[0] - f0[0] - f0[1] * e[i] - f0[2] * (e[j] + e[k]);
  s.d[i] = fa;
  s.d[j] = fb + e[k] * fc;
  s.d[k] = fb + e[j] * fc;
  if constexpr (kHessian) {
    // pair (m, n) is at 3 + m where n = m + 1
    const double aa = f[4], bb = f[5], cc = f[6], ab = f[7], bc = f[8], ca = f[9];
    s.dd[i] = aa;
    s.dd[j] = bb + 2 * e[k] * bc + e[k] * e[k] * cc;
    s.dd[k] = bb + 2 * e[j] * bc + e[j] * e[j] * cc;
    s.dd[3 + i] = ab + e[k] * ca;  // i, j
    s.dd[3 + k] = ab + e[j] * ca;  // k, i
    s.dd[3 + j] = fc + bb + (e[j] + e[k]) * bc + e[j] * e[k] * cc;
  }
  return s;
}

/// psi = omega/2 sum q^2 and its derivatives.
template <bool kHessian>
LogJet energy(const Strain s[3], double omega) {
  LogJet r;
  for (int i = 0; i < 3; ++i) {
    r.psi += omega / 2 * s[i].q * s[i].q;
    for (int m = 0; m < 3; ++m) r.w[m] += omega * s[i].q * s[i].d[m];
    if constexpr (kHessian)
      for (int c = 0; c < 6; ++c)
        r.ww[c] += omega * (s[i].d[kEntryRow[c]] * s[i].d[kEntryColumn[c]] + s[i].q * s[i].dd[c]);
  }
  return r;
}

}  // namespace

void NeuralMtl::strains(const double* e, int64_t n, double* q) const {
  const double omega = 3 * lambda_ + 2 * mu_, a = std::sqrt(2 * mu_ / omega), b = (1 - a) / 3;
  constexpr int kStrains = kAxesAtOnce / 3;
  for (int64_t begin = 0; begin < n; begin += kStrains) {
    const int count = int(std::min<int64_t>(kStrains, n - begin));
    double x[3 * kAxesAtOnce], f[kAxesAtOnce];
    for (int v = 0; v < count; ++v) inputs(e + 3 * (begin + v), x + 9 * v);
    jets<1>(x, 3 * count, f);
    for (int v = 0; v < count; ++v)
      for (int i = 0; i < 3; ++i) {
        const double of_axis[10] = {f[3 * v + i]};
        q[3 * (begin + v) + i] = strain<false>(e + 3 * (begin + v), i, of_axis, f0_, a, b).q;
      }
  }
}

void NeuralMtl::evaluate(const double* e, int64_t n, double* psi) const {
  const double omega = 3 * lambda_ + 2 * mu_;
  std::vector<double> q(3 * size_t(n));
  strains(e, n, q.data());
  for (size_t k = 0; k < size_t(n); ++k)
    psi[k] = omega / 2 *
             (q[3 * k] * q[3 * k] + q[3 * k + 1] * q[3 * k + 1] + q[3 * k + 2] * q[3 * k + 2]);
}

template <bool kHessian>
void NeuralMtl::evaluate(const double* e, int64_t n, LogJet* result) const {
  constexpr int kChannels = kHessian ? 10 : 4, kStrains = kAxesAtOnce / 3;
  const double omega = 3 * lambda_ + 2 * mu_, a = std::sqrt(2 * mu_ / omega), b = (1 - a) / 3;
  for (int64_t begin = 0; begin < n; begin += kStrains) {
    const int count = int(std::min<int64_t>(kStrains, n - begin));
    double x[3 * kAxesAtOnce], f[kChannels * kAxesAtOnce];
    for (int v = 0; v < count; ++v) inputs(e + 3 * (begin + v), x + 9 * v);
    jets<kChannels>(x, 3 * count, f);
    for (int v = 0; v < count; ++v) {
      Strain s[3];
      for (int i = 0; i < 3; ++i) {
        double of_axis[10] = {};
        for (int c = 0; c < kChannels; ++c) of_axis[c] = f[c * 3 * count + 3 * v + i];
        s[i] = strain<kHessian>(e + 3 * (begin + v), i, of_axis, f0_, a, b);
      }
      result[begin + v] = energy<kHessian>(s, omega);
    }
  }
}

template void NeuralMtl::evaluate<false>(const double*, int64_t, LogJet*) const;
template void NeuralMtl::evaluate<true>(const double*, int64_t, LogJet*) const;

}  // namespace elastogen
