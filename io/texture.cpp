// SPDX-License-Identifier: Apache-2.0
#include "io/texture.hpp"

#include "io/byte_reader.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace elastogen {
namespace {

/// Linear light of the 256 bytes of sRGB.
const std::array<float, 256>& light_table() {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> light;
    for (size_t k = 0; k < light.size(); ++k) light[k] = linear_from_srgb(double(k) / 255);
    return light;
  }();
  return table;
}

uint8_t byte_of(float light) {
  return uint8_t(std::lround(255 * srgb_from_linear(std::clamp(light, 0.0f, 1.0f))));
}

Texel texel(const Image& image, int x, int y) {
  const uint8_t* p = image.rgba.data() + 4 * (size_t(y) * size_t(image.width) + size_t(x));
  const auto& light = light_table();
  return {light[p[0]], light[p[1]], light[p[2]], float(p[3]) / 255};
}

/// The mean of each 2 x 2 texels; colours are weighted by alpha.
Image halved(const Image& from) {
  Image half{std::max(1, from.width / 2), std::max(1, from.height / 2), {}};
  half.rgba.resize(4 * size_t(half.width) * size_t(half.height));
  for (int y = 0; y < half.height; ++y)
    for (int x = 0; x < half.width; ++x) {
      Texel sum = {}, plain = {};
      for (int k = 0; k < 4; ++k) {
        const Texel t = texel(from, std::min(2 * x + k % 2, from.width - 1),
                              std::min(2 * y + k / 2, from.height - 1));
        for (size_t c = 0; c < 3; ++c) sum[c] += t[3] * t[c], plain[c] += t[c] / 4;
        sum[3] += t[3];
      }
      uint8_t* to = half.rgba.data() + 4 * (size_t(y) * size_t(half.width) + size_t(x));
      for (size_t c = 0; c < 3; ++c) to[c] = byte_of(sum[3] > 0 ? sum[c] / sum[3] : plain[c]);
      to[3] = uint8_t(std::lround(255 * sum[3] / 4));
    }
  return half;
}

/// A texel's index within 0 ... size - 1.
int wrapped(int64_t k, int size, Wrap wrap) {
  if (wrap == Wrap::kClamp) return int(std::clamp<int64_t>(k, 0, size - 1));
  const int64_t period = wrap == Wrap::kMirror ? 2 * int64_t(size) : size;
  const int64_t within = (k % period + period) % period;
  return int(within < size ? within : period - 1 - within);
}

}  // namespace

Texture::Texture(Image image) {
  levels_.push_back(std::move(image));
  while (levels_.back().width > 1 || levels_.back().height > 1)
    levels_.push_back(halved(levels_.back()));
}

int Texture::level(double covered) const {
  const double level = std::log2(std::max(covered, 1.0)) / 2;
  return std::min(int(level + 0.5), int(levels_.size()) - 1);
}

Texel Texture::at(int level, float u, float v, const std::array<Wrap, 2>& wrap) const {
  const Image& image = levels_[size_t(level)];
  // far outside, single precision cannot resolve texels any more
  const double x = std::clamp(double(u), -1e6, 1e6) * image.width - 0.5;
  const double y = std::clamp(double(v), -1e6, 1e6) * image.height - 0.5;
  const auto left = int64_t(std::floor(x)), top = int64_t(std::floor(y));
  const auto s = float(x - double(left)), t = float(y - double(top));
  Texel sum = {};
  for (int k = 0; k < 4; ++k) {
    const float weight = (k % 2 ? s : 1 - s) * (k / 2 ? t : 1 - t);
    const Texel corner = texel(image, wrapped(left + k % 2, image.width, wrap[0]),
                               wrapped(top + k / 2, image.height, wrap[1]));
    for (size_t c = 0; c < 4; ++c) sum[c] += weight * corner[c];
  }
  return sum;
}

}  // namespace elastogen
