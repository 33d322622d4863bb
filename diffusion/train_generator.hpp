// SPDX-License-Identifier: Apache-2.0
// The tasks `elastogen train autoencoder` and `train diffusion`, each in two sizes:
//
//   compact  whitened principal components of the last layers (weight_codec.hpp) and the denoiser
//   of
//            denoiser.hpp; these are shipped
//   paper    the fully connected autoencoder on all weights (autoencoder_torch.hpp) and a
//            convolutional denoiser of its latents (denoiser_torch.hpp), as ElastoGen describes
//            them
//
// Except for the compact diffusion, every tenth material of a dataset is held out, and the errors
// of the results for these materials are reported.

#pragma once

#include "network/law/learn_library.hpp"
#include "training/fit_neural_mtl.hpp"

namespace elastogen {

struct TrainGenerator {
  std::string dataset;      ///< file of make_dataset
  std::string autoencoder;  ///< file of the autoencoder for the codes; compact: may be empty
  std::string out;
  std::string size = "compact";  ///< or "paper"
  std::string layers;            ///< "N,N,..." in place of the paper's; the last a square
  int components = 64;           ///< of a compact code
  int64_t steps = 0, batch = 0;  ///< of the optimiser; not for a compact autoencoder
  uint64_t seed = 1;
  double rate = 0;  ///< the largest of all steps
  std::string device = "cpu";
  bool resume = false;  ///< resume from the checkpoint OUT.part, if there is one
};

/// Writes the codec or autoencoder. @return kPassing or kStopped. @throws Error as its parts.
TrainEnd train_autoencoder(const TrainGenerator& task, const FitHooks& hooks);

/// Compact: writes the file of a WeightGenerator, without a denoiser if steps is 0. Paper: writes
/// the denoiser of the latents, with the shares of held-out materials that pass when fits start
/// from its samples. @return kPassing or kStopped. @throws Error as its parts.
TrainEnd train_diffusion(const TrainGenerator& task, const FitHooks& hooks);

}  // namespace elastogen
