// SPDX-License-Identifier: Apache-2.0
// The paper's autoencoder of NeuralMTL weights (ElastoGen, section 5): fully connected,
//
//   17153 - 8192 - 4096 - 2048 - 1024 - 512 - 256 and back, SiLU between,
//
// on whole nets, with each weight centred at its mean and divided by its standard deviation. A
// weight that is equal in all nets is neither learned nor changed. The loss is the mean squared
// error over the weights that vary.

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
  /// A random autoencoder, scaled for nets with the mean and spread of these.
  /// @param nets    (n, weights), n > 0.
  /// @param layers  sizes of the layers, the code last. @throws Error (usage) without layers.
  Autoencoder(In<float> nets, const std::vector<int64_t>& layers, uint64_t seed, at::Device device);
  /// Reads the tensors "autoencoder.*" of a file. @throws Error (asset) if any is missing.
  Autoencoder(const TensorFile& file, at::Device device);
  /// Adds these tensors to a file.
  void write(TensorFile& file) const;

  /// Trains it. @return false if it was stopped before the end.
  bool train(In<float> nets, const AutoencoderOptions& options, const FitHooks& hooks);

  int64_t code_size() const { return layers_.back(); }
  int64_t net_size() const { return layers_.front(); }

  /// Codes of nets, (n, weights) to (n, code), and back.
  Array<double> encode(In<float> nets) const;
  Array<float> decode(In<double> codes) const;
  /// Root mean square error over nets and the weights that vary, in their standard deviations.
  double error(In<float> nets) const;

 private:
  at::Tensor standardised(In<float> nets) const;
  at::Tensor encoded(const Parameters& parameters, const at::Tensor& nets) const;
  at::Tensor decoded(const Parameters& parameters, const at::Tensor& codes) const;
  at::Tensor loss(const Parameters& parameters, const at::Tensor& nets) const;

  std::vector<int64_t> layers_;  // sizes, that of the nets first
  at::Device device_;
  at::Tensor mean_, scale_, varies_;  // (weights); varies_: 1 or 0
  Parameters parameters_;             // W and b of the encoder's layers, then of the decoder's
};

}  // namespace elastogen
