// SPDX-License-Identifier: Apache-2.0
// The task `elastogen train mtl`: reads the materials, fits all layers by SOAP, then the last by
// Levenberg-Marquardt, reports, writes.

#pragma once

#include "network/law/learn_library.hpp"
#include "training/fit_neural_mtl.hpp"

namespace elastogen {

struct TrainMtl {
  std::string law = "neo-hookean";  ///< of a single material, with `poisson`
  double poisson = 0.45;
  std::string list;     ///< file of materials instead (read_fit_materials)
  std::string start;    ///< weight file that all nets begin from; empty: random
  std::string out;      ///< file of a single material, folder of a list
  FitOptions fit;       ///< no steps: hidden layers of the start as they are
  int last_layer = 80;  ///< iterations on the last layer; 0: none
};

/// Writes the weights of each material and, for a list, the table report.csv beside them, with
/// shared hidden layers also these, hidden.tensors, whose last layer is 0; also those that fail
/// their report. The checkpoint is OUT.part, removed at the end. When stopped only the checkpoint
/// is written.
/// @throws Error as its parts do.
TrainEnd train_mtl(const TrainMtl& task, const FitHooks& hooks);

}  // namespace elastogen
