// SPDX-License-Identifier: Apache-2.0
// Last layers fitted to many materials on common hidden layers, from which a generator of weights
// is made. In memory, and as an HDF5 file that its user block seals (docs/formats.md).

#pragma once

#include "core/array.hpp"
#include "training/fit_material.hpp"
#include "training/fit_report.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace elastogen {

inline constexpr int kMtlWidthOfLast = kMtlLast - 1;  ///< weights of a last layer, without b3

/// Row n of each member belongs to material n.
struct WeightDataset {
  std::vector<float> hidden;  ///< a NeuralMTL, (17153), with last layer 0
  std::vector<FitMaterial> materials;
  Array<double> features;           ///< (n, 15), material_features
  Array<float> layers;              ///< (n, 128)
  Array<double> errors;             ///< (n, 4): stress median, p99, max, tangent p99 (FitReport)
  std::vector<double> rms;          ///< (n), LastLayerFit::error
  std::vector<int32_t> iterations;  ///< (n), of the fit that was kept

  int64_t count() const { return int64_t(materials.size()); }
  /// Weights of material n, (17153).
  std::vector<float> weights(int64_t n) const;
  /// Whether material n is inside all limits.
  bool passes(int64_t n) const;
};

/// A dataset of n materials with their features; all other members have no values yet.
/// @param hidden  weights of a NeuralMTL, (17153); the last layer is ignored.
/// @throws Error (usage) for another number of weights.
WeightDataset empty_dataset(std::vector<float> hidden, std::vector<FitMaterial> materials);

/// The rows `numbers` of a dataset, in that order.
WeightDataset dataset_rows(const WeightDataset& data, const std::vector<int64_t>& numbers);

/// The bytes of a file. @throws Error (usage) if there is no row or an array has other sizes.
std::string encode_dataset(const WeightDataset& data);

/// Reads the bytes of encode_dataset.
/// @param place  name of the file, for messages.
/// @throws Error (asset) naming the place: no such file, a file that is cut short or changed, an
///         array that is missing or whose type or size does not fit the others or the file, an
///         invalid material, features that are not those of the material, numbers that are not
///         finite, hidden layers whose hash is not the stated one.
WeightDataset decode_dataset(std::string_view bytes, const std::string& place);

}  // namespace elastogen
