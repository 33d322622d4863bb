// SPDX-License-Identifier: Apache-2.0
// Images on surfaces, in several sizes so that a sample has the mean of the area that it covers.

#pragma once

#include "io/base_colour.hpp"
#include "io/decode_image.hpp"

#include <array>
#include <vector>

namespace elastogen {

/// Red, green, blue (linear) and alpha.
using Texel = std::array<float, 4>;

class Texture {
 public:
  explicit Texture(Image image);

  /// Number of texels of the whole image.
  double texels() const { return double(levels_[0].width) * levels_[0].height; }

  /// The level at which a sample covers about one texel.
  /// @param covered  texels of the whole image in a sample.
  int level(double covered) const;

  /// Bilinear interpolation between the centres of texels; v runs down.
  Texel at(int level, float u, float v, const std::array<Wrap, 2>& wrap) const;

 private:
  std::vector<Image> levels_;  ///< each half of the one before, the last 1 x 1
};

}  // namespace elastogen
