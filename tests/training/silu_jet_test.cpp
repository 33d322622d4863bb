// SPDX-License-Identifier: Apache-2.0
#include "training/silu_jet.hpp"

#include "core/error.hpp"
#include "tests/training/scalar_mtl.hpp"
#include "training/silu_jet_impl.hpp"
#include "training/silu_jet_torch.hpp"

#include <ATen/ATen.h>
#include <gtest/gtest.h>
#include <torch/csrc/autograd/autograd.h>

namespace elastogen {
namespace {

constexpr int kFirstOf[6] = {0, 1, 2, 0, 1, 2}, kSecondOf[6] = {0, 1, 2, 1, 2, 0};

/// silu_jet by operations of libtorch, in any precision.
at::Tensor composed(const JetShape& shape, const at::Tensor& z, const at::Tensor& bias) {
  const auto block = [&](int64_t begin, int64_t channels, int64_t points) {
    const at::Tensor jets =
        z.narrow(1, begin, channels * points).view({shape.nets, channels, points, shape.width});
    const at::Tensor value = jets.select(1, 0) + bias.unsqueeze(1), s = value.sigmoid();
    const at::Tensor first = s * (1 + value * (1 - s));
    const at::Tensor second = s * (1 - s) * (2 + value * (1 - 2 * s));
    std::vector<at::Tensor> out = {value * s};
    for (int m = 0; m < 3; ++m) out.push_back(first * jets.select(1, 1 + m));
    for (int k = 0; k + 4 < channels; ++k)
      out.push_back(second * jets.select(1, 1 + kFirstOf[k]) * jets.select(1, 1 + kSecondOf[k]) +
                    first * jets.select(1, 4 + k));
    return at::cat(out, 1);
  };
  return at::cat({block(0, 10, shape.second), block(10 * shape.second, 4, shape.first)}, 1);
}

double relative_difference(const at::Tensor& a, const at::Tensor& b) {
  return ((a.to(at::kDouble) - b).norm() / b.norm()).item<double>();
}

class SiluJet : public testing::Test {
 protected:
  const JetShape shape = {2, 5, 7, 16};
  at::Tensor z, bias, weights;

  void SetUp() override {
    at::manual_seed(1);
    z = 2 * at::randn({shape.nets, shape.rows(), shape.width});
    bias = at::randn({shape.nets, shape.width});
    weights = at::randn_like(z);
  }
};

TEST_F(SiluJet, FollowsTheDerivativesOfACurve) {
  // z(h) = z + h z_0 + h^2/2 z_00 moves along input 0
  const double value = 0.7, rise = -1.3, bend = 0.4;
  double jet[10] = {value, rise, 0, 0, bend, 0, 0, 0, 0, 0}, out[10];
  float in[10], result[10];
  for (int c = 0; c < 10; ++c) in[c] = float(jet[c]);
  silu::forward<10>(in, result);
  const auto curve = [&](double h) { return test::silu(value + h * rise + h * h / 2 * bend); };
  out[0] = curve(0);
  out[1] = test::slope(curve, 1e-3);
  out[4] = test::slope(
      [&](double d) { return test::slope([&](double h) { return curve(d + h); }, 4e-3); }, 4e-3);
  for (const int c : {0, 1, 4}) EXPECT_NEAR(result[c], out[c], 3e-7);
}

TEST_F(SiluJet, AgreesWithComposedOperationsInDouble) {
  const at::Tensor expected = composed(shape, z.to(at::kDouble), bias.to(at::kDouble));
  EXPECT_LT(relative_difference(silu_jet(shape, z, bias), expected), 3e-7);
}

TEST_F(SiluJet, HasTheGradientOfComposedOperationsInDouble) {
  const at::Tensor z1 = z.clone().requires_grad_(), b1 = bias.clone().requires_grad_();
  const at::Tensor z2 = z.to(at::kDouble).requires_grad_(),
                   b2 = bias.to(at::kDouble).requires_grad_();
  const auto fused = torch::autograd::grad({(silu_jet(shape, z1, b1) * weights).sum()}, {z1, b1});
  const auto expected =
      torch::autograd::grad({(composed(shape, z2, b2) * weights.to(at::kDouble)).sum()}, {z2, b2});
  for (size_t k = 0; k < 2; ++k) EXPECT_LT(relative_difference(fused[k], expected[k]), 3e-7);
}

TEST_F(SiluJet, KeepsItsDigitsFarOut) {
  at::Tensor far = at::zeros({1, 4, 16});
  for (int h = 0; h < 16; ++h) far[0][0][h] = -120 + 16 * h;
  const at::Tensor a = silu_jet({1, 0, 1, 16}, far, at::zeros({1, 16}));
  for (int h = 0; h < 16; ++h) {
    const double exact = test::silu(-120 + 16 * h);
    EXPECT_NEAR(a[0][0][h].item<double>(), exact, 1e-6 * std::abs(exact) + 1e-35);
  }
}

TEST_F(SiluJet, PassesOnWhatIsNoNumber) {
  at::Tensor broken = at::zeros({1, 4, 16});
  broken[0][0][3] = std::nan("");
  const at::Tensor a = silu_jet({1, 0, 1, 16}, broken, at::zeros({1, 16}));
  EXPECT_TRUE(std::isnan(a[0][0][3].item<double>()));
  EXPECT_EQ(a.isnan().sum().item<int64_t>(), 4);  // the channels of that neuron
}

TEST_F(SiluJet, TakesBlocksWithoutPoints) {
  const JetShape plain = {2, 0, 3, 16}, second = {2, 3, 0, 16}, none = {2, 0, 0, 16};
  for (const JetShape& s : {plain, second, none}) {
    const at::Tensor part = z.narrow(1, 0, s.rows()).contiguous();
    const at::Tensor a = silu_jet(s, part, bias);
    const at::Tensor expected = composed(s, part.to(at::kDouble), bias.to(at::kDouble));
    EXPECT_LT((a.to(at::kDouble) - expected).abs().sum().item<double>(), 1e-4);
  }
}

TEST_F(SiluJet, RejectsWhatItsDocumentationForbids) {
  EXPECT_THROW(silu_jet({2, 5, 6, 16}, z, bias), Error);
  EXPECT_THROW(silu_jet(shape, z, bias.narrow(1, 0, 8)), Error);
  EXPECT_THROW(silu_jet(shape, z.to(at::kDouble), bias), Error);
  EXPECT_THROW(silu_jet(shape, z.transpose(0, 1).contiguous().transpose(0, 1), bias), Error);
}

}  // namespace
}  // namespace elastogen
