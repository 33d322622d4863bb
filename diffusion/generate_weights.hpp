// SPDX-License-Identifier: Apache-2.0
// Last layers for materials that were never fitted. They come from one file that is shipped beside
// the hidden layers: a codec, the codes of the fits from which it was made, a regression and
// optionally a denoiser. A fit that starts from them (training/last_layer_fit.hpp) needs few or
// none.

#pragma once

#include "diffusion/denoiser.hpp"
#include "diffusion/weight_codec.hpp"
#include "diffusion/weight_regression.hpp"

#include <optional>

namespace elastogen {

/// Origin of a last layer.
enum class Start {
  kZero,           ///< 0, Hencky's law
  kAncestor,       ///< the known fit nearest to the mean of all, for any material
  kNearest,        ///< the nearest known fit, by the distance of the regression
  kInterpolation,  ///< the eight nearest, weighted by 1 / squared distance
  kRegression,     ///< kernel regression
  kDiffusion,      ///< a sample of the diffusion, DDIM with 50 steps
};

inline constexpr Start kStarts[] = {Start::kZero,          Start::kAncestor,   Start::kNearest,
                                    Start::kInterpolation, Start::kRegression, Start::kDiffusion};

const char* name_of(Start start);

/// Parts of a generator.
struct GeneratorParts {
  std::string hidden;  ///< hidden_hash of the layers that it fits
  WeightCodec codec;
  WeightRegression regression;
  Array<double> codes;  ///< of the known fits, (n, components)
  std::optional<Denoiser> denoiser;
};

class WeightGenerator {
 public:
  /// @throws Error (usage) if the sizes of the parts do not fit.
  explicit WeightGenerator(GeneratorParts parts);
  /// @param place  name of the file, for messages.
  /// @throws Error (asset) naming the place: another form, missing parts, or sizes that do not fit.
  WeightGenerator(const TensorFile& file, const std::string& place);
  TensorFile file() const;

  /// hidden_hash of the layers to which its last layers belong.
  const std::string& hidden() const { return parts_.hidden; }
  const WeightCodec& codec() const { return parts_.codec; }
  bool has_denoiser() const { return parts_.denoiser.has_value(); }

  /// A last layer for a material, (128).
  /// @param seed  seed of the noise of a diffusion.
  /// @throws Error (usage) for a diffusion if there is no denoiser.
  std::vector<float> last_layer(const FitMaterial& material, Start start, uint64_t seed = 0) const;

 private:
  std::vector<double> code(const std::vector<double>& features, Start start, uint64_t seed) const;
  std::vector<double> mean_of_nearest(const std::vector<double>& features, int64_t count) const;
  std::vector<double> diffused(const std::vector<double>& features, uint64_t seed) const;

  GeneratorParts parts_;
};

/// A generator from a dataset and a codec, without a denoiser.
WeightGenerator make_generator(const WeightDataset& data, const WeightCodec& codec);

}  // namespace elastogen
