// SPDX-License-Identifier: Apache-2.0
// The task `elastogen train mtl`: reads the materials, fits all layers by SOAP, then the last layer
// by Levenberg-Marquardt, reports and writes.

#pragma once

#include "network/law/learn_library.hpp"
#include "training/fit_neural_mtl.hpp"

namespace elastogen {

struct TrainMtl {
  std::string law = "neo-hookean";  ///< law of a single material, with `poisson`
  double poisson = 0.45;
  std::string list;     ///< file of materials in place of one law (read_fit_materials)
  std::string start;    ///< weight file from which all nets start; empty: random
  std::string out;      ///< file for a single material, folder for a list
  FitOptions fit;       ///< without steps the hidden layers of the start are kept
  int last_layer = 80;  ///< iterations on the last layer; 0: none
};

/// Writes the weights of each material, also of those that miss their limits. For a list it adds
/// the table report.csv and, with shared hidden layers, the file hidden.tensors of these with last
/// layer 0. The checkpoint is OUT.part, which is removed at the end. If stopped, only the
/// checkpoint is written.
/// @throws Error as its parts.
TrainEnd train_mtl(const TrainMtl& task, const FitHooks& hooks);

}  // namespace elastogen
