// SPDX-License-Identifier: Apache-2.0
// NeuralMTL of many materials at once, differentiable in the weights: f: 3 -> 128 -> 128 -> 1 with
// SiLU, one net for each material, in log stretches e_i = ln sigma_i:
//
//   x_i = (e_i, e_j + e_k, e_j e_k)
//   q_i = (a + b) e_i + b (e_j + e_k) + f(x_i) - f(0) - f_0 e_i - f_1 (e_j + e_k)
//   psi = omega/2 sum_i q_i^2,   omega = 3 lambda + 2 mu,  a = sqrt(2 mu/omega),  b = (1 - a)/3
//
// where f_0, f_1 are the slopes of f at 0 in its first two inputs. Then psi, stress and tangent at
// rest are those of the material for any weights. All nets use the same strains. The jets are in
// e_0, e_1, e_2: w_m = dpsi/de_m = omega sum_i q_i q_i,m and w_mn = omega sum_i (q_i,m q_i,n + q_i
// q_i,mn), then t_m = w_m/sigma_m and H_mn = (w_mn - delta_mn w_m)/(sigma_m sigma_n).

#pragma once

#include "core/array.hpp"
#include "training/fit_material.hpp"

#include <ATen/core/Tensor.h>

#include <array>

namespace elastogen {

inline constexpr int kMtlWidth = 128;

/// Weights of the nets. b3 cancels in f - f(0) and is left out.
struct MtlNets {
  at::Tensor W1;  ///< (nets, 128, 3)
  at::Tensor b1;  ///< (nets, 128)
  at::Tensor W2;  ///< (nets, 128, 128)
  at::Tensor b2;  ///< (nets, 128)
  at::Tensor w3;  ///< (nets, 128)

  int64_t count() const { return W1.size(0); }
  std::array<at::Tensor, 5> tensors() const { return {W1, b1, W2, b2, w3}; }
};

inline constexpr int64_t kMtlTrained = kMtlParameters - 1;

/// Views of one block of numbers, (nets * 17152): W1 of all nets, then b1 of all nets, and so on.
MtlNets nets_of_block(const at::Tensor& block);

/// A block from flat weights, (nets, 17153), and back; the flat order is W1 b1 W2 b2 w3 b3.
at::Tensor block_of_weights(const Array<float>& weights, at::Device device);
Array<float> weights_of_block(const at::Tensor& block);

/// Constants of the materials in the formulas.
struct MtlAnchors {
  at::Tensor slope;  ///< (nets, 2): a + b, b
  at::Tensor omega;  ///< (nets, 1)
};
MtlAnchors mtl_anchors(const std::vector<FitMaterial>& materials, at::Device device);

/// Strains as inputs of the nets, in blocks of rows as in silu_jet.hpp: the first `second` strains
/// with second derivatives, then the other strains and the state at rest without them.
struct MtlPoints {
  int64_t second = 0, first = 0;  ///< strains
  at::Tensor jets;                ///< x_i and its derivatives in e, (rows, 3)
  at::Tensor inverse_stretch;     ///< 1/sigma, (3, strains)

  int64_t strains() const { return second + first; }
};
MtlPoints mtl_points(const Array<double>& e, int64_t second, at::Device device);

/// Energy, stress and tangent in stretches, divided by Young's modulus.
struct MtlResponse {
  at::Tensor psi;  ///< (nets, strains)
  at::Tensor t;    ///< (nets, 3, strains)
  at::Tensor H;    ///< 00 11 22 01 12 20, (nets, 6, second)
};
MtlResponse mtl_response(const MtlNets& nets, const MtlAnchors& anchors, const MtlPoints& points);

}  // namespace elastogen
