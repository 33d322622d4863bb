// SPDX-License-Identifier: Apache-2.0
#include "training/silu_jet_torch.hpp"

#include "core/error.hpp"
#include "core/pack.hpp"

#include <ATen/ATen.h>
#include <torch/csrc/autograd/custom_function.h>

namespace elastogen {
namespace {

using torch::autograd::AutogradContext;
using torch::autograd::variable_list;

const float* data(const at::Tensor& tensor) {
  return tensor.data_ptr<float>();
}

at::Tensor value(const JetShape& shape, const at::Tensor& z, const at::Tensor& bias) {
  at::Tensor a = at::empty_like(z);
#ifdef ELASTOGEN_CUDA
  if (z.is_cuda()) {
    cuda::silu_jet(shape, data(z), data(bias), a.data_ptr<float>());
    return a;
  }
#endif
  cpu::silu_jet(shape, data(z), data(bias), a.data_ptr<float>());
  return a;
}

at::Tensor gradient(const JetShape& shape, const at::Tensor& z, const at::Tensor& bias,
                    const at::Tensor& g) {
  at::Tensor dz = at::empty_like(z);
#ifdef ELASTOGEN_CUDA
  if (z.is_cuda()) {
    cuda::silu_jet_gradient(shape, data(z), data(bias), data(g), dz.data_ptr<float>());
    return dz;
  }
#endif
  cpu::silu_jet_gradient(shape, data(z), data(bias), data(g), dz.data_ptr<float>());
  return dz;
}

struct SiluJet : torch::autograd::Function<SiluJet> {
  static at::Tensor forward(AutogradContext* context, const at::Tensor& z, const at::Tensor& bias,
                            int64_t second, int64_t first) {
    context->save_for_backward({z, bias});
    context->saved_data["second"] = second;
    context->saved_data["first"] = first;
    return value({z.size(0), second, first, z.size(2)}, z, bias);
  }

  static variable_list backward(AutogradContext* context, variable_list g) {
    const variable_list saved = context->get_saved_variables();
    const at::Tensor &z = saved[0], &bias = saved[1];
    const JetShape shape = {z.size(0), context->saved_data["second"].toInt(),
                            context->saved_data["first"].toInt(), z.size(2)};
    const at::Tensor dz = gradient(shape, z, bias, g[0].contiguous());
    // the bias acts on the values only
    const at::Tensor dbias =
        dz.narrow(1, 0, shape.second).sum(1) + dz.narrow(1, 10 * shape.second, shape.first).sum(1);
    return {dz, dbias, at::Tensor(), at::Tensor()};
  }
};

}  // namespace

at::Tensor silu_jet(const JetShape& shape, const at::Tensor& z, const at::Tensor& bias) {
  ELASTOGEN_CHECK(shape.width % kLanes == 0 && shape.width <= 1024, "width must be a multiple of ",
                  kLanes, " up to 1024, got ", shape.width);
  ELASTOGEN_CHECK(z.sizes() == at::IntArrayRef({shape.nets, shape.rows(), shape.width}),
                  "z must be (nets, rows, width), got ", z.sizes());
  ELASTOGEN_CHECK(bias.sizes() == at::IntArrayRef({shape.nets, shape.width}),
                  "bias must be (nets, width), got ", bias.sizes());
  for (const at::Tensor& tensor : {z, bias})
    ELASTOGEN_CHECK(tensor.scalar_type() == at::kFloat && tensor.is_contiguous() &&
                        tensor.device() == z.device(),
                    "silu_jet takes contiguous float32 tensors of one device");
  return SiluJet::apply(z, bias, shape.second, shape.first);
}

}  // namespace elastogen
