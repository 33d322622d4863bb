// SPDX-License-Identifier: Apache-2.0
// Last layers for materials that were never fitted, from one file that is shipped beside the hidden
// layers: a codec, the codes of the fits it was made from, a regression and, if it was trained, a
// denoiser. A fit that begins there (training/last_layer_fit.hpp) needs few iterations or none.

#pragma once

#include "diffusion/denoiser.hpp"
#include "diffusion/weight_codec.hpp"
#include "diffusion/weight_regression.hpp"

#include <optional>

namespace elastogen {

/// Where a last layer comes from.
enum class Start {
  kZero,           ///< 0, Hencky's law
  kAncestor,       ///< one for all: of the known fits the one nearest to their mean
  kNearest,        ///< the nearest known fit, by the distance of the regression
  kInterpolation,  ///< the eight nearest, by the inverse of the squared distance
  kRegression,     ///< kernel regression
  kDiffusion,      ///< a sample of the diffusion, DDIM with 50 steps
};

inline constexpr Start kStarts[] = {Start::kZero,          Start::kAncestor,   Start::kNearest,
                                    Start::kInterpolation, Start::kRegression, Start::kDiffusion};

const char* name_of(Start start);

/// What a generator is made of.
struct GeneratorParts {
  std::string hidden;  ///< hidden_hash of the layers it is for
  WeightCodec codec;
  WeightRegression regression;
  Array<double> codes;  ///< of the known fits, (n, components)
  std::optional<Denoiser> denoiser;
};

class WeightGenerator {
 public:
  /// @throws Error (usage) if the parts are not of the same sizes.
  explicit WeightGenerator(GeneratorParts parts);
  /// @param place  name of the file, for messages.
  /// @throws Error (asset) that names the place: of another form, parts missing or of other sizes.
  WeightGenerator(const TensorFile& file, const std::string& place);
  TensorFile file() const;

  /// hidden_hash of the layers that its last layers belong to.
  const std::string& hidden() const { return parts_.hidden; }
  const WeightCodec& codec() const { return parts_.codec; }
  bool has_denoiser() const { return parts_.denoiser.has_value(); }

  /// A last layer for a material, (128).
  /// @param seed  of the noise of a diffusion.
  /// @throws Error (usage) for a diffusion without a denoiser.
  std::vector<float> last_layer(const FitMaterial& material, Start start, uint64_t seed = 0) const;

 private:
  std::vector<double> code(const std::vector<double>& features, Start start, uint64_t seed) const;
  std::vector<double> mean_of_nearest(const std::vector<double>& features, int64_t count) const;
  std::vector<double> diffused(const std::vector<double>& features, uint64_t seed) const;

  GeneratorParts parts_;
};

/// A generator without a denoiser of a dataset and a codec.
WeightGenerator make_generator(const WeightDataset& data, const WeightCodec& codec);

}  // namespace elastogen
