// SPDX-License-Identifier: Apache-2.0
// Fits NeuralMTLs to laws, many at once. All start from one net and use the same strains, so that
// weights of similar materials are similar. Per net, with the errors of fit_problem_torch.hpp:
//
//   mean stress^2 + 0.1 mean tangent^2 + 0.1 mean clip(energy, -3, 3)^2
//
// minimised by SOAP (soap_torch.hpp); its rate rises over the first steps and falls to 0 as a
// cosine. With shared hidden layers all nets have the same hidden layers, and the mean of the
// losses' logarithms is minimised, so that the layers serve all materials alike; last_layer_fit.hpp
// fits the last layers afterwards.

#pragma once

#include "core/array.hpp"
#include "training/fit_material.hpp"

#include <functional>
#include <span>

namespace elastogen {

struct FitOptions {
  int64_t steps = 3000;
  int64_t samples = 512;  ///< strains a step; the tangent is fitted on a third of them
  uint64_t seed = 1;      ///< seed of the start and of the strains
  /// Weights from which all nets start, (17153), or one start for each, (materials, 17153); empty:
  /// random.
  std::vector<float> start;
  bool shared = false;    ///< one pair of hidden layers for all nets
  double rate = 3e-3;     ///< the largest of all steps
  int64_t warm_up = 200;  ///< steps over which it rises
  std::string device = "cpu";
  std::string checkpoint;           ///< file; empty: none
  int64_t checkpoint_steps = 1000;  ///< steps between two checkpoints
  bool resume = false;              ///< resume from the checkpoint, if there is one
};

/// Calls by which a long run reports and asks whether to stop.
struct FitHooks {
  std::function<void(const std::string&)> say = [](const std::string&) {};
  std::function<bool()> stopped = [] { return false; };
};

struct FitOutcome {
  Array<float> weights;  ///< (materials, 17153): W1 b1 W2 b2 w3 b3, row-major
  int64_t steps = 0;     ///< steps made, fewer than all if stopped
  double seconds = 0;    ///< of this run
};

/// On CPUs every run with one number of threads gives the same bits, resumed or not.
/// @throws Error (usage) on empty lists, a start of another size and counts that are not positive,
///         (asset) on a checkpoint of other materials or options, (resources) when files cannot be
///         written.
FitOutcome fit_neural_mtl(const std::vector<FitMaterial>& materials, const FitOptions& options,
                          const FitHooks& hooks = {});

/// "random", or the SHA-256 of the weights from which a fit starts.
std::string start_name(const FitOptions& options);

/// The random start of a seed, (17153): uniform within 1/sqrt(inputs) of each layer, b3 = 0.
std::vector<float> initial_weights(uint64_t seed);

}  // namespace elastogen
