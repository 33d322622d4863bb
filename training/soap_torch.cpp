// SPDX-License-Identifier: Apache-2.0
#include "training/soap_torch.hpp"

#include "training/orthonormal_basis.hpp"

#include <ATen/ATen.h>

#include <cmath>

namespace elastogen {
namespace {

constexpr double kDecay = 0.95, kNormFloor = 1e-8;
constexpr int64_t kRefreshSteps = 10;

at::Tensor identities(int64_t batch, int64_t side, at::Device device) {
  return at::eye(side, at::TensorOptions().dtype(at::kFloat).device(device)).repeat({batch, 1, 1});
}

at::Tensor transposed(const at::Tensor& A) {
  return A.transpose(1, 2);
}

void add_mean(at::Tensor& mean, const at::Tensor& now) {
  mean.mul_(kDecay).add_(now, 1 - kDecay);
}

/// Bases closer to the eigenvectors of S, in the order of the old basis: Q of S Q_old.
at::Tensor refreshed(const at::Tensor& S, const at::Tensor& old) {
  // scale S to about 1, as squares of small gradients would leave the range of float
  const at::Tensor trace = S.diagonal(0, 1, 2).sum(1).clamp_min(1e-30).view({-1, 1, 1});
  const at::Tensor A = at::bmm(S / trace, old).contiguous();
  at::Tensor Q = at::empty_like(A);
  const float* const from = A.data_ptr<float>();
  float* const to = Q.data_ptr<float>();
#ifdef ELASTOGEN_CUDA
  if (A.is_cuda()) {
    cuda::orthonormal_bases(A.size(0), int(A.size(1)), from, to);
    return Q;
  }
#endif
  cpu::orthonormal_bases(A.size(0), int(A.size(1)), from, to);
  return Q;
}

}  // namespace

Soap::Soap(int64_t batch, int64_t rows, int64_t columns, at::Device device)
    : L_(at::zeros({batch, rows, rows}, device)),
      R_(at::zeros({batch, columns, columns}, device)),
      QL_(identities(batch, rows, device)),
      QR_(identities(batch, columns, device)),
      M_(at::zeros({batch, rows, columns}, device)),
      V_(at::zeros({batch, rows, columns}, device)) {}

at::Tensor Soap::update(const at::Tensor& G, double rate, int64_t step) {
  add_mean(L_, at::bmm(G, transposed(G)));
  add_mean(R_, at::bmm(transposed(G), G));
  if (step % kRefreshSteps == 1) {
    QL_ = refreshed(L_, QL_);
    QR_ = refreshed(R_, QR_);
  }
  const auto turned = [&](const at::Tensor& A) {
    return at::bmm(at::bmm(transposed(QL_), A), QR_);
  };
  const at::Tensor g = turned(G);
  add_mean(M_, G);
  add_mean(V_, g * g);
  const double known = 1 - std::pow(kDecay, double(step));
  const at::Tensor size = (V_ / known).sqrt_().add_(kNormFloor);
  return at::bmm(at::bmm(QL_, turned(M_) / size), transposed(QR_)) * (rate / known);
}

}  // namespace elastogen
