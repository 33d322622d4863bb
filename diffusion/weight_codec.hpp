// SPDX-License-Identifier: Apache-2.0
// Last layers as few meaningful numbers. To first order, the distance of two codes is the root mean
// square of the relative change of stress between the two nets,
//
//   z = L^T (w - mean w),   L L^T = mean over the fits of J^T J   (LastLayer::stress_metric)
//   c = P^T z,              P: the first principal components of z
//   w = mean w + L^-T P c

#pragma once

#include "core/array.hpp"
#include "core/tensor_file.hpp"
#include "diffusion/weight_dataset.hpp"
#include "training/fit_neural_mtl.hpp"

#include <optional>
#include <span>

namespace elastogen {

class WeightCodec {
 public:
  /// @param layers  (n, 128), n > 1.
  /// @param metric  mean of J^T J, (128, 128), symmetric.
  /// @param components  upper limit; n - 1 layers and 128 weights limit the number too.
  /// @throws Error (usage) for other sizes and a metric that is not positive.
  WeightCodec(In<float> layers, In<double> metric, int components);

  /// Reads the tensors "codec.*" of a file. @throws Error (asset) if any is missing.
  explicit WeightCodec(const TensorFile& file);
  /// Adds these tensors to a file.
  void write(TensorFile& file) const;

  int components() const { return int(scale_.size()); }
  /// Root mean square of each component over the layers, the largest first, (components).
  const std::vector<double>& scale() const { return scale_; }
  /// Loss of the code: root mean square over the layers of |z - P c|.
  double lost() const { return lost_; }

  /// Codes of last layers: (n, 128) to (n, components).
  Array<double> encode(In<float> layers) const;
  /// The last layer of a code, (components) to (128). @throws Error (usage) for another size.
  std::vector<float> decode(std::span<const double> code) const;

 private:
  Array<double> mean_;         // (1, 128)
  Array<double> to_, from_;    // (components, 128) and (128, components)
  std::vector<double> scale_;  // (components)
  double lost_ = 0;
};

/// The codec of a dataset, with J of each material at its fit; no value if stopped.
/// @throws Error (usage) for a dataset of one material.
std::optional<WeightCodec> make_codec(const WeightDataset& data, int components,
                                      const FitHooks& hooks = {});

}  // namespace elastogen
