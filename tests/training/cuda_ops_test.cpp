// SPDX-License-Identifier: Apache-2.0
// The CUDA loops against those of the CPU, on the same numbers. Nothing is here in builds without
// CUDA; skipped where there is no device.

#ifdef ELASTOGEN_CUDA

#include "training/fit_neural_mtl.hpp"
#include "training/fit_report.hpp"
#include "training/law_targets.hpp"
#include "training/orthonormal_basis.hpp"
#include "training/silu_jet.hpp"
#include "training/strain_sampler.hpp"

#include <ATen/ATen.h>
#include <gtest/gtest.h>

#include <cstring>

namespace elastogen {
namespace {

double relative_difference(const at::Tensor& a, const at::Tensor& b) {
  return ((a.cpu() - b).norm() / b.norm()).item<double>();
}

class CudaOps : public testing::Test {
 protected:
  void SetUp() override {
    if (!at::hasCUDA()) GTEST_SKIP() << "there is no CUDA device here";
    at::manual_seed(2);
  }
};

TEST_F(CudaOps, SiluJetAndItsGradient) {
  const JetShape shape = {3, 37, 50, 128};
  const at::Tensor z = 2 * at::randn({shape.nets, shape.rows(), shape.width}),
                   bias = at::randn({shape.nets, shape.width}), g = at::randn_like(z);
  at::Tensor a = at::empty_like(z), dz = at::empty_like(z);
  cpu::silu_jet(shape, z.data_ptr<float>(), bias.data_ptr<float>(), a.data_ptr<float>());
  cpu::silu_jet_gradient(shape, z.data_ptr<float>(), bias.data_ptr<float>(), g.data_ptr<float>(),
                         dz.data_ptr<float>());
  const at::Tensor z2 = z.cuda(), bias2 = bias.cuda(), g2 = g.cuda();
  at::Tensor a2 = at::zeros_like(z2), dz2 = at::zeros_like(z2);
  cuda::silu_jet(shape, z2.data_ptr<float>(), bias2.data_ptr<float>(), a2.data_ptr<float>());
  cuda::silu_jet_gradient(shape, z2.data_ptr<float>(), bias2.data_ptr<float>(),
                          g2.data_ptr<float>(), dz2.data_ptr<float>());
  EXPECT_LT(relative_difference(a2, a), 1e-6);
  EXPECT_LT(relative_difference(dz2, dz), 1e-6);
}

TEST_F(CudaOps, LawTargets) {
  const std::vector<FitMaterial> materials = {fit_material("neo-hookean", 0.3),
                                              fit_material("0.5*stvk+0.5*hencky", 0.45)};
  // laws as bytes
  at::Tensor laws = at::empty({2, int64_t(sizeof(TargetLaw))}, at::kByte);
  for (int n = 0; n < 2; ++n) {
    const TargetLaw law = target_law(materials[size_t(n)]);
    std::memcpy(laws.data_ptr<uint8_t>() + n * int64_t(sizeof law), &law, sizeof law);
  }
  const Array<double> strains = sample_strains(kFitBox, 3, 0, 300);
  const at::Tensor e =
      at::from_blob(const_cast<double*>(strains.data()), {300, 3}, at::kDouble).clone();
  // the loop of one device
  const auto run = [&](at::Device device) {
    const auto options = at::TensorOptions().dtype(at::kFloat).device(device);
    const at::Tensor l = laws.to(device), x = e.to(device);
    std::array<at::Tensor, 3> r = {at::zeros({2, 300}, options), at::zeros({2, 3, 300}, options),
                                   at::zeros({2, 6, 100}, options)};
    const LawTargets to = {r[0].data_ptr<float>(), r[1].data_ptr<float>(), r[2].data_ptr<float>(),
                           100};
    const auto* law = reinterpret_cast<const TargetLaw*>(l.data_ptr<uint8_t>());
    if (device.is_cuda())
      cuda::law_targets(law, 2, x.data_ptr<double>(), 300, to);
    else
      cpu::law_targets(law, 2, x.data_ptr<double>(), 300, to);
    return r;
  };
  const auto host = run(at::kCPU), device = run(at::Device(at::kCUDA, 0));
  for (size_t k = 0; k < 3; ++k) EXPECT_LT(relative_difference(device[k], host[k]), 1e-6);
}

TEST_F(CudaOps, OrthonormalBases) {
  for (const int n : {1, 3, 32, 128, 160}) {
    const at::Tensor A = at::randn({5, n, n});
    at::Tensor Q = at::empty_like(A);
    cpu::orthonormal_bases(5, n, A.data_ptr<float>(), Q.data_ptr<float>());
    const at::Tensor A2 = A.cuda();
    at::Tensor Q2 = at::zeros_like(A2);
    cuda::orthonormal_bases(5, n, A2.data_ptr<float>(), Q2.data_ptr<float>());
    EXPECT_LT(relative_difference(Q2, Q), 1e-3) << n;  // of ill-conditioned columns fewer digits
    const at::Tensor one = at::bmm(Q2.transpose(1, 2), Q2).cpu();
    EXPECT_LT((one - at::eye(n)).abs().max().item<double>(), 1e-5) << n;
  }
}

}  // namespace
}  // namespace elastogen

#endif  // ELASTOGEN_CUDA
