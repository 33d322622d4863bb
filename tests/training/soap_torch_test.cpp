// SPDX-License-Identifier: Apache-2.0
#include "training/soap_torch.hpp"

#include <ATen/ATen.h>
#include <gtest/gtest.h>

namespace elastogen {
namespace {

TEST(Soap, FirstUpdateHasUnitSizeInTheBasisOfTheGradient) {
  // G = diag(3, 0.01) is its own basis: one known gradient gives M / sqrt V = +-1
  const at::Tensor G = at::diag_embed(at::tensor({3.f, -0.01f})).unsqueeze(0);
  Soap soap(1, 2, 2, at::kCPU);
  const at::Tensor d = soap.update(G, 0.5, 1);
  EXPECT_NEAR(d[0][0][0].item<double>(), 0.5, 1e-4);
  EXPECT_NEAR(d[0][1][1].item<double>(), -0.5, 1e-4);
  EXPECT_NEAR(d[0][0][1].item<double>(), 0, 1e-6);
}

TEST(Soap, UpdatesOfTurnedGradientsAreTurned) {
  // in the eigenbasis the axes of the parameters do not count, unlike in Adam
  at::manual_seed(3);
  const at::Tensor Q = std::get<0>(at::linalg_qr(at::randn({1, 6, 6})));
  Soap plain(1, 6, 4, at::kCPU), turned(1, 6, 4, at::kCPU);
  const at::Tensor base = at::randn({1, 6, 4});
  double cosine = 0;
  for (int step = 1; step <= 301; ++step) {  // thirty refreshes: both have found the eigenvectors
    const at::Tensor G = base + 0.02 * at::randn({1, 6, 4});
    const at::Tensor a = plain.update(G, 1, step), b = turned.update(at::bmm(Q, G), 1, step);
    cosine = ((at::bmm(Q, a) * b).sum() / (a.norm() * b.norm())).item<double>();
  }
  EXPECT_GT(cosine, 0.9);
}

TEST(Soap, DescendsAnIllConditionedQuadratic) {
  // |A W B - C|^2 with condition numbers of 100 on both sides, two problems at once
  at::manual_seed(1);
  const auto ill = [](int64_t n) {
    const at::Tensor U = std::get<0>(at::linalg_qr(at::randn({2, n, n})));
    const at::Tensor V = std::get<0>(at::linalg_qr(at::randn({2, n, n})));
    return at::bmm(U * at::logspace(-2, 0, n), V);
  };
  const at::Tensor A = ill(12), B = ill(8), C = at::bmm(at::bmm(A, at::randn({2, 12, 8})), B);
  at::Tensor W = at::zeros({2, 12, 8});
  Soap soap(2, 12, 8, at::kCPU);
  const int steps = 600;
  for (int step = 1; step <= steps; ++step) {
    const at::Tensor miss = at::bmm(at::bmm(A, W), B) - C;
    const at::Tensor G = at::bmm(at::bmm(A.transpose(1, 2), miss), B.transpose(1, 2));
    W.sub_(soap.update(G, 0.05 * (1 - double(step - 1) / steps), step));
  }
  const at::Tensor miss = at::bmm(at::bmm(A, W), B) - C;
  for (int k = 0; k < 2; ++k) EXPECT_LT((miss[k].norm() / C[k].norm()).item<double>(), 1e-2);
}

}  // namespace
}  // namespace elastogen
