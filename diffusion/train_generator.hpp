// SPDX-License-Identifier: Apache-2.0
// The tasks `elastogen train autoencoder` and `train diffusion`, each in two sizes:
//
//   compact  whitened principal components of the last layers (weight_codec.hpp) and the denoiser
//            of denoiser.hpp: what is shipped
//   paper    the fully connected autoencoder on all weights (autoencoder_torch.hpp) and a
//            convolutional denoiser of its latents (denoiser_torch.hpp): what ElastoGen describes
//
// Every tenth material of a dataset is held out, of the compact diffusion excepted, and the errors
// of what is made for those are stated.

#pragma once

#include "network/law/learn_library.hpp"
#include "training/fit_neural_mtl.hpp"

namespace elastogen {

struct TrainGenerator {
  std::string dataset;      ///< file of make_dataset
  std::string autoencoder;  ///< file that codes are taken from; compact: may be empty
  std::string out;
  std::string size = "compact";  ///< or "paper"
  std::string layers;            ///< "N,N,..." in place of the paper's; the last a square
  int components = 64;           ///< of a compact code
  int64_t steps = 0, batch = 0;  ///< of the optimiser; a compact autoencoder has none
  uint64_t seed = 1;
  double rate = 0;  ///< the largest
  std::string device = "cpu";
  bool resume = false;  ///< from the checkpoint OUT.part, where there is one
};

/// Writes the codec or autoencoder. @return kPassing or kStopped. @throws Error as its parts do.
TrainEnd train_autoencoder(const TrainGenerator& task, const FitHooks& hooks);

/// Compact: writes the file of a WeightGenerator, without steps one without a denoiser. Paper: the
/// denoiser of the latents, with the shares of held-out materials that are inside all limits when
/// fits begin at its samples. @return kPassing or kStopped. @throws Error as its parts do.
TrainEnd train_diffusion(const TrainGenerator& task, const FitHooks& hooks);

}  // namespace elastogen
