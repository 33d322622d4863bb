// SPDX-License-Identifier: Apache-2.0
#include "cli/picture/canvas.hpp"

#include "io/byte_reader.hpp"

namespace elastogen {
namespace {

/// The byte of each share of light in steps of 2^-14, less than half a step of the darkest bytes.
std::vector<uint8_t> byte_table() {
  std::vector<uint8_t> bytes((1 << 14) + 1);
  for (size_t k = 0; k < bytes.size(); ++k)
    bytes[k] = uint8_t(std::lround(255 * srgb_from_linear(double(k) / double(1 << 14))));
  return bytes;
}

}  // namespace

void develop(const Canvas& canvas, Pixels& pixels) {
  static const std::vector<uint8_t> bytes = byte_table();
  for (int y = canvas.first / kSamples; y < (canvas.first + canvas.rows) / kSamples; ++y) {
    uint8_t* to = pixels.row(0, y);
    for (int x = 0; x < pixels.width; ++x)
      for (size_t c = 0; c < 3; ++c) {
        float sum = 0;
        for (int s = 0; s < kSamples * kSamples; ++s)
          sum += canvas.light[canvas.sample(kSamples * x + s % kSamples,
                                            kSamples * y + s / kSamples)][c];
        const float mean = std::clamp(sum / (kSamples * kSamples), 0.0f, 1.0f);
        *to++ = bytes[size_t(std::lround(mean * float(1 << 14)))];
      }
  }
}

Light light_of_srgb(const Vec3& colour) {
  return {linear_from_srgb(colour[0]), linear_from_srgb(colour[1]), linear_from_srgb(colour[2])};
}

}  // namespace elastogen
