// SPDX-License-Identifier: Apache-2.0
// Minimises a loss by AdamW (Loshchilov, Hutter 2019). The rate rises over the first steps and
// falls to 0 as a cosine. With the gradient g at step k, all by element:
//
//   m <- 0.9 m + 0.1 g,   v <- 0.999 v + 0.001 g^2
//   w <- (1 - rate decay) w - rate m/(1 - 0.9^k) / (sqrt(v/(1 - 0.999^k)) + 1e-8)
//
// The result may be the running mean of the weights: a <- d a + (1 - d) w with
// d = min(average, (1 + k)/(10 + k)).

#pragma once

#include "training/fit_neural_mtl.hpp"

#include <ATen/core/Generator.h>
#include <ATen/core/Tensor.h>

#include <string>
#include <vector>

namespace elastogen {

struct LoopOptions {
  int64_t steps = 1000;
  double rate = 1e-3;               ///< the largest of all steps
  int64_t warm_up = 200;            ///< steps over which it rises
  double decay = 1e-2;              ///< decay of the weights
  double average = 0;               ///< largest d; 0: the result is the weights themselves
  std::string identity;             ///< all settings that decide the numbers, for the checkpoint
  std::string checkpoint;           ///< file; empty: none
  int64_t checkpoint_steps = 5000;  ///< steps between two checkpoints
  bool resume = false;              ///< resume from the checkpoint, if there is one
};

struct LoopOutcome {
  std::vector<at::Tensor> parameters;
  int64_t steps = 0;  ///< steps made, fewer than all if stopped
};

using Parameters = std::vector<at::Tensor>;
/// The loss of parameters, a scalar. Its random numbers may depend on the step only.
using StepLoss = std::function<at::Tensor(const Parameters& parameters, int64_t step)>;

/// On CPUs every run with one number of threads gives the same bits, resumed or not.
/// @throws Error (usage) without parameters or steps, (asset) on a checkpoint of another identity
///         or other sizes, (resources) when files cannot be written.
LoopOutcome train_loop(const Parameters& start, const StepLoss& loss, const LoopOptions& options,
                       const FitHooks& hooks);

/// Random numbers for a step of a seed, on the CPU.
at::Generator step_generator(uint64_t seed, int64_t step);

/// Adds W, (rows, columns), uniform within 1/sqrt(columns), and b = 0, (rows).
void add_linear(Parameters& parameters, int64_t rows, int64_t columns, at::Generator& generator,
                at::Device device);

/// Floats of a tensor, and a tensor of numbers on a device.
std::vector<float> floats_of(const at::Tensor& tensor);
at::Tensor tensor_of(In<double> values, at::Device device);

}  // namespace elastogen
