// SPDX-License-Identifier: Apache-2.0
// The state of a fit on disk. A fit that was interrupted continues from it with the same bits.

#pragma once

#include "training/fit_neural_mtl.hpp"

#include <optional>

namespace elastogen {

struct FitCheckpoint {
  int64_t step = 0;
  std::vector<std::vector<float>> numbers;  ///< weights, then the state of the optimiser
};

/// Replaces the file once the new one is complete. @throws Error (resources) if that fails.
void write_checkpoint(const std::string& path, const std::vector<FitMaterial>& materials,
                      const FitOptions& options, const FitCheckpoint& checkpoint);

/// No value if there is no file. @throws Error (asset) if the file belongs to other materials or
/// options, is damaged, or has another number of parts.
std::optional<FitCheckpoint> read_checkpoint(const std::string& path,
                                             const std::vector<FitMaterial>& materials,
                                             const FitOptions& options, size_t parts);

}  // namespace elastogen
