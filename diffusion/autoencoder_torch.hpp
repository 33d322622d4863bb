// SPDX-License-Identifier: Apache-2.0
// The paper's autoencoder of NeuralMTL weights (ElastoGen, section 5): fully connected,
//
//   17153 - 8192 - 4096 - 2048 - 1024 - 512 - 256 and back, SiLU between,
//
// on whole nets, each weight less its mean and over its standard deviation; a weight that is the
// same in all nets is neither learned nor changed. The loss is the mean square of the miss over the
// weights that vary.

#pragma once

#include "core/tensor_file.hpp"
#include "diffusion/train_loop_torch.hpp"

#include <optional>

namespace elastogen {

inline constexpr int64_t kPaperLayers[] = {8192, 4096, 2048, 1024, 512, 256};

struct AutoencoderOptions {
  LoopOptions loop;
  std::vector<int64_t> layers = {std::begin(kPaperLayers), std::end(kPaperLayers)};
  int64_t batch = 256;
  uint64_t seed = 1;
  std::string device = "cpu";
};

class Autoencoder {
 public:
  /// A random one, for nets of the mean and spread of these.
  /// @param nets    (n, weights), n > 0.
  /// @param layers  sizes, the last that of the code. @throws Error (usage) without layers.
  Autoencoder(In<float> nets, const std::vector<int64_t>& layers, uint64_t seed, at::Device device);
  /// Takes the tensors "autoencoder.*" of a file. @throws Error (asset) if they are not all there.
  Autoencoder(const TensorFile& file, at::Device device);
  /// Adds them to a file.
  void write(TensorFile& file) const;

  /// Trains it. @return whether it was not stopped before the end.
  bool train(In<float> nets, const AutoencoderOptions& options, const FitHooks& hooks);

  int64_t code_size() const { return layers_.back(); }
  int64_t net_size() const { return layers_.front(); }

  /// (n, weights) to (n, code) and back.
  Array<double> encode(In<float> nets) const;
  Array<float> decode(In<double> codes) const;
  /// Root mean square of the miss over nets and the weights that vary, in their standard
  /// deviations.
  double error(In<float> nets) const;

 private:
  at::Tensor standardised(In<float> nets) const;
  at::Tensor encoded(const Parameters& parameters, const at::Tensor& nets) const;
  at::Tensor decoded(const Parameters& parameters, const at::Tensor& codes) const;
  at::Tensor loss(const Parameters& parameters, const at::Tensor& nets) const;

  std::vector<int64_t> layers_;  // that of the nets first
  at::Device device_;
  at::Tensor mean_, scale_, varies_;  // (weights); varies_: 1 or 0
  Parameters parameters_;             // W and b of the encoder's layers, then of the decoder's
};

}  // namespace elastogen
