// SPDX-License-Identifier: Apache-2.0
#include "training/neural_mtl_torch.hpp"

#include "core/error.hpp"
#include "tests/training/scalar_mtl.hpp"
#include "training/fit_neural_mtl.hpp"
#include "training/strain_sampler.hpp"

#include <ATen/ATen.h>
#include <gtest/gtest.h>

namespace elastogen {
namespace {

constexpr int kRow[6] = {0, 1, 2, 0, 1, 2}, kColumn[6] = {0, 1, 2, 1, 2, 0};

/// Two nets of random weights, for two materials.
class NeuralMtlTorch : public testing::Test {
 protected:
  const std::vector<FitMaterial> materials = {fit_material("stvk", 0.2),
                                              fit_material("stvk", 0.49)};
  const std::vector<float> one = initial_weights(1), other = initial_weights(2);
  Array<float> weights{2, kMtlParameters};

  void SetUp() override {
    std::copy(one.begin(), one.end(), weights.row(0));
    std::copy(other.begin(), other.end(), weights.row(1));
  }

  const std::vector<float>& row(int64_t net) const { return net == 0 ? one : other; }

  MtlResponse response(const Array<double>& e, int64_t second) const {
    return mtl_response(nets_of_block(block_of_weights(weights, at::kCPU)),
                        mtl_anchors(materials, at::kCPU), mtl_points(e, second, at::kCPU));
  }
};

TEST_F(NeuralMtlTorch, AgreesWithTheFormulasInDouble) {
  const Array<double> e = sample_strains(kFitBox, 4, 0, 9);
  const int64_t second = 4;
  const MtlResponse r = response(e, second);
  for (int64_t net = 0; net < 2; ++net) {
    const double nu = materials[size_t(net)].poisson;
    const double omega = 3 * materials[size_t(net)].lambda() + 2 * materials[size_t(net)].mu();
    for (int64_t n = 0; n < e.rows(); ++n) {
      const Vec3 s = {std::exp(e(n, 0)), std::exp(e(n, 1)), std::exp(e(n, 2))};
      const double psi = test::psi(row(net), nu, s);
      // q is a difference of numbers near 1, rounded to 6e-8 a few times; dpsi = omega q dq
      const double rounding = 3e-7 * std::sqrt(2 * omega * psi);
      EXPECT_NEAR(r.psi[net][n].item<double>(), psi, rounding + 1e-6 * psi);
      for (int i = 0; i < 3; ++i) {
        const double t = test::stress(row(net), nu, s, i);
        EXPECT_NEAR(r.t[net][i][n].item<double>(), t, 1e-5 * std::abs(t) + 1e-5);
      }
      for (int k = 0; n < second && k < 6; ++k) {
        const double H = test::tangent(row(net), nu, s, kRow[k], kColumn[k]);
        EXPECT_NEAR(r.H[net][k][n].item<double>(), H, 1e-5 * std::abs(H) + 1e-4);
      }
    }
  }
}

TEST_F(NeuralMtlTorch, IsLinearElasticityAtRestForAnyWeights) {
  const MtlResponse r = response(Array<double>(1, 3), 1);
  for (int64_t net = 0; net < 2; ++net) {
    const double mu = materials[size_t(net)].mu(), lambda = materials[size_t(net)].lambda();
    EXPECT_LT(r.psi[net].abs().max().item<double>(), 1e-12);
    EXPECT_LT(r.t[net].abs().max().item<double>(), 1e-5);
    for (int k = 0; k < 6; ++k) {
      const double H = lambda + (k < 3 ? 2 * mu : 0);
      EXPECT_NEAR(r.H[net][k][0].item<double>(), H, 2e-6 * (2 * mu + lambda));
    }
  }
}

TEST_F(NeuralMtlTorch, KnowsNoAxisFromAnother) {
  const Array<double> e = sample_strains(kFitBox, 4, 0, 6);
  Array<double> turned(6, 3);
  for (int64_t n = 0; n < 6; ++n)
    for (int i = 0; i < 3; ++i) turned(n, (i + 1) % 3) = e(n, i);
  const MtlResponse a = response(e, 6), b = response(turned, 6);
  EXPECT_LT(((a.psi - b.psi) / a.psi).abs().max().item<double>(), 1e-4);
  const at::Tensor t = b.t.roll({-1}, {1});
  EXPECT_LT(((a.t - t).norm() / a.t.norm()).item<double>(), 1e-5);
}

TEST_F(NeuralMtlTorch, KeepsWeightsThroughTheBlock) {
  const Array<float> back = weights_of_block(block_of_weights(weights, at::kCPU));
  EXPECT_EQ(back, weights);  // b3 of the start is 0
}

TEST_F(NeuralMtlTorch, TakesNoSecondDerivativesOrOnlySuch) {
  const Array<double> e = sample_strains(kFitBox, 4, 0, 6);
  const MtlResponse all = response(e, 6), none = response(e, 0);
  EXPECT_EQ(none.H.numel(), 0);
  EXPECT_LT(((all.psi - none.psi) / all.psi).abs().max().item<double>(), 1e-4);
}

TEST_F(NeuralMtlTorch, RejectsRowsOfAnotherLength) {
  EXPECT_THROW(block_of_weights(Array<float>(2, 17152), at::kCPU), Error);
}

}  // namespace
}  // namespace elastogen
