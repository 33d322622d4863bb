// SPDX-License-Identifier: Apache-2.0
// Where a fit stands, on disk, so that it can go on after an interruption with the same bits.

#pragma once

#include "training/fit_neural_mtl.hpp"

#include <optional>

namespace elastogen {

struct FitCheckpoint {
  int64_t step = 0;
  std::vector<std::vector<float>> numbers;  ///< weights, then the state of the optimiser
};

/// Replaces the file when the new one is whole. @throws Error (resources) if it cannot.
void write_checkpoint(const std::string& path, const std::vector<FitMaterial>& materials,
                      const FitOptions& options, const FitCheckpoint& checkpoint);

/// Nothing where there is no file. @throws Error (asset) if it is of other materials or options,
/// broken, or not of as many parts.
std::optional<FitCheckpoint> read_checkpoint(const std::string& path,
                                             const std::vector<FitMaterial>& materials,
                                             const FitOptions& options, size_t parts);

}  // namespace elastogen
