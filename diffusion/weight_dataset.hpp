// SPDX-License-Identifier: Apache-2.0
// Last layers fitted to many materials on the same hidden layers, what a generator of weights is
// made from. In memory, and as an HDF5 file whose user block seals it (docs/formats.md).

#pragma once

#include "core/array.hpp"
#include "training/fit_material.hpp"
#include "training/fit_report.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace elastogen {

inline constexpr int kMtlWidthOfLast = kMtlLast - 1;  ///< weights of a last layer, without b3

/// Row n of each member is of material n.
struct WeightDataset {
  std::vector<float> hidden;  ///< a NeuralMTL, (17153), whose last layer is 0
  std::vector<FitMaterial> materials;
  Array<double> features;           ///< (n, 15), material_features
  Array<float> layers;              ///< (n, 128)
  Array<double> errors;             ///< (n, 4): stress median, p99, max, tangent p99 (FitReport)
  std::vector<double> rms;          ///< (n), LastLayerFit::error
  std::vector<int32_t> iterations;  ///< (n), of the fit that is kept

  int64_t count() const { return int64_t(materials.size()); }
  /// Weights of material n, (17153).
  std::vector<float> weights(int64_t n) const;
  /// Whether material n is inside all limits.
  bool passes(int64_t n) const;
};

/// A dataset of n materials with room for the rest, whose features are filled in.
/// @param hidden  weights of a NeuralMTL, (17153); the last layer is ignored.
/// @throws Error (usage) for another number of weights.
WeightDataset empty_dataset(std::vector<float> hidden, std::vector<FitMaterial> materials);

/// The rows `numbers` of a dataset, in that order.
WeightDataset dataset_rows(const WeightDataset& data, const std::vector<int64_t>& numbers);

/// The bytes of a file. @throws Error (usage) if there is no row or an array has other sizes.
std::string encode_dataset(const WeightDataset& data);

/// Reads such bytes.
/// @param place  name of the file, for messages.
/// @throws Error (asset) that names the place: no such file, cut short or changed, an array missing
///         or of another type or size than the others or than the file has room for, a material
///         that is none, features that are not its own, numbers that are not finite, hidden layers
///         whose hash is not the one stated.
WeightDataset decode_dataset(std::string_view bytes, const std::string& place);

}  // namespace elastogen
