// SPDX-License-Identifier: Apache-2.0
#include "training/fit_problem_torch.hpp"

#include "core/error.hpp"
#include "training/law_targets.hpp"

#include <ATen/ATen.h>

namespace elastogen {
namespace {

/// |A|^2 of symmetric matrices, (nets, 6, strains).
at::Tensor frobenius_squared(const at::Tensor& A) {
  const at::Tensor squares = A * A;
  return squares.narrow(1, 0, 3).sum(1) + 2 * squares.narrow(1, 3, 3).sum(1);
}

}  // namespace

FitProblem::FitProblem(const std::vector<FitMaterial>& materials, at::Device device)
    : device_(device), count_(int64_t(materials.size())), anchors_(mtl_anchors(materials, device)) {
  at::Tensor laws = at::empty({count_, int64_t(sizeof(TargetLaw))}, at::kByte);
  at::Tensor modulus = at::empty({count_, 1});
  for (int64_t n = 0; n < count_; ++n) {
    const FitMaterial& material = materials[size_t(n)];
    const TargetLaw law = target_law(material);
    std::memcpy(laws.data_ptr<uint8_t>() + n * int64_t(sizeof law), &law, sizeof law);
    modulus[n][0] = 2 * material.mu() + material.lambda();
  }
  laws_ = laws.to(device);
  modulus_ = modulus.to(device);
}

MtlResponse FitProblem::targets(const Array<double>& e, int64_t second) const {
  const int64_t strains = e.rows();
  const at::Tensor points =
      at::from_blob(const_cast<double*>(e.data()), {strains, 3}, at::kDouble).to(device_);
  const auto options = at::TensorOptions().dtype(at::kFloat).device(device_);
  const MtlResponse r = {at::empty({count_, strains}, options),
                         at::empty({count_, 3, strains}, options),
                         at::empty({count_, 6, second}, options)};
  const LawTargets to = {r.psi.data_ptr<float>(), r.t.data_ptr<float>(), r.H.data_ptr<float>(),
                         second};
  const auto* laws = reinterpret_cast<const TargetLaw*>(laws_.data_ptr<uint8_t>());
#ifdef ELASTOGEN_CUDA
  if (device_.is_cuda()) {
    cuda::law_targets(laws, count_, points.data_ptr<double>(), strains, to);
    return r;
  }
#endif
  cpu::law_targets(laws, count_, points.data_ptr<double>(), strains, to);
  return r;
}

BatchErrors FitProblem::errors(const MtlNets& nets, const Array<double>& e, int64_t second) const {
  const MtlResponse target = targets(e, second);
  const MtlResponse net = mtl_response(nets, anchors_, mtl_points(e, second, device_));
  const at::Tensor size = (target.t * target.t).sum(1).sqrt() + 1e-4 * modulus_;
  const at::Tensor miss = net.t - target.t;
  BatchErrors errors;
  errors.stress = (miss * miss).sum(1) / (size * size);
  errors.tangent = frobenius_squared(net.H - target.H) / frobenius_squared(target.H);
  errors.energy = (net.psi - target.psi) / (target.psi + 1e-6 * modulus_);
  return errors;
}

at::Device fit_device(const std::string& name) {
  if (name == "cpu") return at::kCPU;
  ELASTOGEN_CHECK(name == "cuda", "device '", name, "' is not known; cpu and cuda are");
#ifdef ELASTOGEN_CUDA
  ELASTOGEN_CHECK(at::hasCUDA(), "there is no CUDA device here");
  return at::Device(at::kCUDA, 0);
#else
  throw Error("this build has no CUDA; configure with ELASTOGEN_CUDA=ON and a libtorch with CUDA");
#endif
}

}  // namespace elastogen
