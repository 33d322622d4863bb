// SPDX-License-Identifier: Apache-2.0
// The denoiser of codes, without libtorch: a net with three hidden layers of SiLU,
//
//   x_0 = W_4 silu(W_3 silu(W_2 silu(W_1 [x_t, embedding(t), features] + b_1) + b_2) + b_3) + b_4
//
// in float. The embedding has sin and cos of t 10000^(-2 k/d), k = 0 ... d/2 - 1. Features are
// centred at their mean and divided by their scale.

#pragma once

#include "core/array.hpp"
#include "core/tensor_file.hpp"

#include <array>
#include <span>
#include <vector>

namespace elastogen {

inline constexpr int kDenoiserLayers = 4, kTimeEmbedding = 64;

/// Sizes of the layers of a denoiser.
struct DenoiserSizes {
  int code = 64, features = 15, width = 512;

  int inputs() const { return code + kTimeEmbedding + features; }
  int rows(int layer) const { return layer == kDenoiserLayers - 1 ? code : width; }
  int columns(int layer) const { return layer == 0 ? inputs() : width; }
};

/// Mean and standard deviation of features, (features); the scale is 1 where they do not vary.
struct FeatureScale {
  std::vector<float> mean, scale;
};

/// The scale of features (n, features), n > 0.
FeatureScale feature_scale(In<double> features);

/// sin, then cos, of the embedding of a time, (64).
std::vector<float> time_embedding(int t);

class Denoiser {
 public:
  /// Weights W, (rows, columns) row-major, and b, (rows), of each layer.
  struct Layer {
    std::vector<float> W, b;
  };
  using Layers = std::array<Layer, kDenoiserLayers>;

  /// @throws Error (usage) for layers or scales of other sizes.
  Denoiser(const DenoiserSizes& sizes, Layers layers, FeatureScale scale);
  /// Reads the tensors "denoiser.*" of a file. @throws Error (asset) if any is missing or does not
  /// fit these sizes of code and features.
  Denoiser(const TensorFile& file, int code, int features);
  /// Adds these tensors to a file.
  void write(TensorFile& file) const;

  const DenoiserSizes& sizes() const { return sizes_; }

  /// The prediction of x_0, (code). @throws Error (usage) for other sizes.
  std::vector<float> x0(std::span<const float> x, int t, std::span<const float> features) const;

 private:
  DenoiserSizes sizes_;
  Layers layers_;
  FeatureScale scale_;
};

}  // namespace elastogen
