// SPDX-License-Identifier: Apache-2.0
#include "training/neural_mtl_torch.hpp"

#include "core/error.hpp"
#include "training/silu_jet_torch.hpp"

#include <ATen/ATen.h>

#include <cmath>

namespace elastogen {
namespace {

/// Shapes of the five tensors for a number of nets.
std::array<std::vector<int64_t>, 5> shapes(int64_t nets) {
  constexpr int64_t w = kMtlWidth;
  return {{{nets, w, 3}, {nets, w}, {nets, w, w}, {nets, w}, {nets, w}}};
}

/// Writes x_i and derivatives in e to rows point, point + stride, ...: 4 or 10 channels.
void write_jet(const double* e, int axis, float* to, int64_t stride, bool second) {
  const int j = (axis + 1) % 3, k = (axis + 2) % 3;
  const auto row = [&](int channel) { return to + channel * stride * 3; };
  row(0)[0] = float(e[axis]), row(0)[1] = float(e[j] + e[k]), row(0)[2] = float(e[j] * e[k]);
  row(1 + axis)[0] = 1;
  row(1 + j)[1] = row(1 + k)[1] = 1;
  row(1 + j)[2] = float(e[k]), row(1 + k)[2] = float(e[j]);
  // only the second derivative of e_j e_k is not zero; 01 12 20 are channels 7, 8, 9
  if (second) row(7 + j)[2] = 1;
}

/// Writes the state at rest, with derivatives in x in place of e.
void write_rest(float* to, int64_t stride) {
  for (int m = 0; m < 3; ++m) to[(1 + m) * stride * 3 + m] = 1;
}

/// The jets of f, (nets, rows).
at::Tensor net_jets(const MtlNets& nets, const MtlPoints& points) {
  const JetShape shape = {nets.count(), 3 * points.second, 3 * points.first + 1, kMtlWidth};
  const at::Tensor x = points.jets.expand({shape.nets, shape.rows(), 3});
  const at::Tensor z1 = at::bmm(x, nets.W1.transpose(1, 2));
  const at::Tensor a1 = silu_jet(shape, z1, nets.b1);
  const at::Tensor z2 = at::bmm(a1, nets.W2.transpose(1, 2));
  const at::Tensor a2 = silu_jet(shape, z2, nets.b2);
  return at::bmm(a2, nets.w3.unsqueeze(2)).squeeze(2);
}

/// Jets of q in the two blocks of rows.
struct AnchoredJets {
  at::Tensor second;  ///< (nets, 10, 3 axes, second)
  at::Tensor all;     ///< (nets, 4, 3 axes, strains)
};

AnchoredJets anchored_jets(const MtlNets& nets, const MtlAnchors& anchors,
                           const MtlPoints& points) {
  const int64_t n = nets.count(), split = 30 * points.second, plain = 3 * points.first + 1;
  const at::Tensor f = net_jets(nets, points);
  const at::Tensor rest = f.narrow(1, split, 4 * plain).view({n, 4, plain}).select(2, plain - 1);
  // the anchor is linear in x, so its jets are linear in those of x
  const at::Tensor slope = anchors.slope - rest.narrow(1, 1, 2);
  const at::Tensor value = rest.narrow(1, 0, 1).unsqueeze(2);
  const at::Tensor q = f + at::matmul(slope, points.jets.narrow(1, 0, 2).t());

  const at::Tensor second = q.narrow(1, 0, split).view({n, 10, 3, points.second});
  const at::Tensor first = q.narrow(1, split, 4 * plain)
                               .view({n, 4, plain})
                               .narrow(2, 0, plain - 1)
                               .view({n, 4, 3, points.first});
  const at::Tensor all = at::cat({second.narrow(1, 0, 4), first}, 3);
  const at::Tensor shifted = all.narrow(1, 0, 1) - value.unsqueeze(3);
  return {second, at::cat({shifted, all.narrow(1, 1, 3)}, 1)};
}

/// w_mn of the strains that have second derivatives, (nets, 6, second).
at::Tensor log_hessian(const AnchoredJets& jets, const at::Tensor& omega) {
  const int64_t second = jets.second.size(3);
  const at::Tensor q = jets.all.narrow(1, 0, 1).narrow(3, 0, second);
  const at::Tensor dq = jets.all.narrow(1, 1, 3).narrow(3, 0, second);
  const at::Tensor next = at::cat({dq.narrow(1, 1, 2), dq.narrow(1, 0, 1)}, 1);
  const at::Tensor products = at::cat({dq * dq, dq * next}, 1);
  return omega * (products + q * jets.second.narrow(1, 4, 6)).sum(2);
}

}  // namespace

MtlNets nets_of_block(const at::Tensor& block) {
  const int64_t nets = block.size(0) / kMtlTrained;
  std::array<at::Tensor, 5> parts;
  int64_t begin = 0;
  const auto all = shapes(nets);
  for (size_t k = 0; k < 5; ++k) {
    int64_t size = 1;
    for (const int64_t side : all[k]) size *= side;
    parts[k] = block.narrow(0, begin, size).view(all[k]);
    begin += size;
  }
  return {parts[0], parts[1], parts[2], parts[3], parts[4]};
}

at::Tensor block_of_weights(const Array<float>& weights, at::Device device) {
  ELASTOGEN_CHECK(weights.cols() == kMtlParameters, "weights must be (nets, ", kMtlParameters,
                  "), got ", Span<const float>(weights));
  const int64_t nets = weights.rows();
  const at::Tensor rows =
      at::from_blob(const_cast<float*>(weights.data()), {nets, kMtlParameters}, at::kFloat);
  std::vector<at::Tensor> parts;
  int64_t begin = 0;
  for (const auto& shape : shapes(1)) {
    int64_t size = 1;
    for (const int64_t side : shape) size *= side;
    parts.push_back(rows.narrow(1, begin, size).reshape({-1}));
    begin += size;
  }
  return at::cat(parts).to(device);
}

Array<float> weights_of_block(const at::Tensor& block) {
  const int64_t nets = block.size(0) / kMtlTrained;
  std::vector<at::Tensor> parts;
  for (const at::Tensor& tensor : nets_of_block(block.cpu()).tensors())
    parts.push_back(tensor.reshape({nets, -1}));
  parts.push_back(at::zeros({nets, 1}));
  const at::Tensor rows = at::cat(parts, 1).contiguous();
  Array<float> weights(nets, kMtlParameters);
  std::copy_n(rows.data_ptr<float>(), weights.size(), weights.data());
  return weights;
}

MtlAnchors mtl_anchors(const std::vector<FitMaterial>& materials, at::Device device) {
  const auto nets = int64_t(materials.size());
  at::Tensor slope = at::zeros({nets, 2}), omega = at::zeros({nets, 1});
  for (int64_t n = 0; n < nets; ++n) {
    const double mu = materials[size_t(n)].mu(), lambda = materials[size_t(n)].lambda();
    const double a = std::sqrt(2 * mu / (3 * lambda + 2 * mu)), b = (1 - a) / 3;
    slope[n][0] = a + b, slope[n][1] = b;
    omega[n][0] = 3 * lambda + 2 * mu;
  }
  return {slope.to(device), omega.to(device)};
}

MtlPoints mtl_points(const Array<double>& e, int64_t second, at::Device device) {
  const int64_t strains = e.rows(), first = strains - second, plain = 3 * first + 1;
  at::Tensor jets = at::zeros({30 * second + 4 * plain, 3}), inverse = at::empty({3, strains});
  float* const rows = jets.data_ptr<float>();
  float* const rest_rows = rows + 3 * (30 * second);
  for (int64_t s = 0; s < strains; ++s) {
    for (int i = 0; i < 3; ++i) {
      inverse.data_ptr<float>()[i * strains + s] = float(std::exp(-e(s, i)));
      if (s < second)
        write_jet(e.row(s), i, rows + 3 * (i * second + s), 3 * second, true);
      else
        write_jet(e.row(s), i, rest_rows + 3 * (i * first + s - second), plain, false);
    }
  }
  write_rest(rest_rows + 3 * (plain - 1), plain);
  return {second, first, jets.to(device), inverse.to(device)};
}

MtlResponse mtl_response(const MtlNets& nets, const MtlAnchors& anchors, const MtlPoints& points) {
  const AnchoredJets jets = anchored_jets(nets, anchors, points);
  const at::Tensor omega = anchors.omega.unsqueeze(2);
  const at::Tensor q = jets.all.narrow(1, 0, 1), dq = jets.all.narrow(1, 1, 3);
  const at::Tensor w = omega * (q * dq).sum(2);

  MtlResponse response;
  response.psi = anchors.omega / 2 * (q * q).sum(2).squeeze(1);
  response.t = w * points.inverse_stretch;
  const int64_t second = points.second;
  const at::Tensor inverse = points.inverse_stretch.narrow(1, 0, second);
  const at::Tensor next = at::cat({inverse.narrow(0, 1, 2), inverse.narrow(0, 0, 1)}, 0);
  const at::Tensor hessian = log_hessian(jets, omega);
  const at::Tensor diagonal = hessian.narrow(1, 0, 3) - w.narrow(2, 0, second);
  response.H = at::cat({diagonal * inverse * inverse, hessian.narrow(1, 3, 3) * inverse * next}, 1);
  return response;
}

}  // namespace elastogen
