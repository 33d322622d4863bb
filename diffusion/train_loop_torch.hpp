// SPDX-License-Identifier: Apache-2.0
// Makes a loss small by AdamW (Loshchilov, Hutter 2019), whose rate rises over the first steps and
// falls to 0 as a cosine. With the gradient g at step k, all by element:
//
//   m <- 0.9 m + 0.1 g,   v <- 0.999 v + 0.001 g^2
//   w <- (1 - rate decay) w - rate m/(1 - 0.9^k) / (sqrt(v/(1 - 0.999^k)) + 1e-8)
//
// What comes out may be the running mean of the weights: a <- d a + (1 - d) w with
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
  double rate = 1e-3;               ///< the largest
  int64_t warm_up = 200;            ///< steps over which it rises
  double decay = 1e-2;              ///< of the weights
  double average = 0;               ///< 0: the weights themselves come out
  std::string identity;             ///< all that decides the numbers, for the checkpoint
  std::string checkpoint;           ///< file; empty: none
  int64_t checkpoint_steps = 5000;  ///< between two of them
  bool resume = false;              ///< from the checkpoint, where there is one
};

struct LoopOutcome {
  std::vector<at::Tensor> parameters;
  int64_t steps = 0;  ///< done, of all; fewer when stopped
};

using Parameters = std::vector<at::Tensor>;
/// The loss of parameters, a scalar; what it draws may depend on the step alone.
using StepLoss = std::function<at::Tensor(const Parameters& parameters, int64_t step)>;

/// On CPUs the same bits in every run with the same number of threads, resumed or not.
/// @throws Error (usage) without parameters or steps, (asset) on a checkpoint of another identity
///         or other sizes, (resources) when files cannot be written.
LoopOutcome train_loop(const Parameters& start, const StepLoss& loss, const LoopOptions& options,
                       const FitHooks& hooks);

/// Random numbers of a step of a seed, on the CPU.
at::Generator step_generator(uint64_t seed, int64_t step);

/// W, (rows, columns), uniform within 1/sqrt(columns), and b, (rows), 0.
void add_linear(Parameters& parameters, int64_t rows, int64_t columns, at::Generator& generator,
                at::Device device);

/// Floats of a tensor, and a tensor of numbers on a device.
std::vector<float> floats_of(const at::Tensor& tensor);
at::Tensor tensor_of(In<double> values, at::Device device);

}  // namespace elastogen
