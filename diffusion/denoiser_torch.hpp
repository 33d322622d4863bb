// SPDX-License-Identifier: Apache-2.0
// Trains denoisers (diffusion/sampler.hpp) to predict x_0 from x_t, with t uniform in 1 ... 200 and
// the mean squared error as loss. There are two kinds: the net of denoiser.hpp for compact codes,
// and a residual convolutional net for the paper's latents, seen as an image of one channel.

#pragma once

#include "diffusion/denoiser.hpp"
#include "diffusion/sampler.hpp"
#include "diffusion/train_loop_torch.hpp"

#include <optional>

namespace elastogen {

struct DenoiserOptions {
  LoopOptions loop;
  int64_t batch = 512;
  uint64_t seed = 1;
  int width = 512;  ///< of the hidden layers, or channels of the convolutions
  std::string device = "cpu";
};

/// Trains the net of denoiser.hpp; returns the running mean of its weights, no value if stopped.
/// @param codes     (n, code), each column with mean square about 1. @param features  (n,
///                  features).
/// @throws Error (usage) on other sizes, and as train_loop.
std::optional<Denoiser> train_denoiser(In<double> codes, In<double> features,
                                       const DenoiserOptions& options, const FitHooks& hooks);

/// A residual convolutional denoiser of images of one channel, side x side:
///
///   h = conv(x),  four times h <- h + conv(silu(conv(silu(h)) + A c)),  x_0 = conv(silu(h))
///
/// with 3 x 3 convolutions and c = silu(B [embedding(t), features] + b), equal at all places.
class ConvDenoiser {
 public:
  static constexpr int kBlocks = 4;

  /// A random denoiser. @param side  edge of the images.
  ConvDenoiser(int side, int channels, FeatureScale scale, uint64_t seed, at::Device device);

  /// x_0, (batch, side * side), from x_t of that size, t (batch) and standardised features.
  at::Tensor x0(const Parameters& parameters, const at::Tensor& x, const at::Tensor& t,
                const at::Tensor& features) const;

  /// Trains it. @return false if it was stopped before the end.
  bool train(In<double> images, In<double> features, const DenoiserOptions& options,
             const FitHooks& hooks);
  /// A sample for features, (side * side), by DDIM with 50 steps.
  std::vector<double> sample(const double* features, uint64_t seed) const;

  /// Adds its weights, scales of features and sizes to a file, as "convolution.*".
  void write(TensorFile& file) const;
  const Parameters& parameters() const { return parameters_; }

 private:
  int side_;
  FeatureScale scale_;
  at::Device device_;
  at::Tensor of_time_;  // embeddings of times 0 ... T
  Parameters parameters_;
};

}  // namespace elastogen
