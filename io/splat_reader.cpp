// SPDX-License-Identifier: Apache-2.0
#include "io/splat_reader.hpp"

#include "io/byte_reader.hpp"
#include "io/safe_file.hpp"
#include "io/splat_ply.hpp"

namespace elastogen {
namespace {

constexpr size_t kSplatBytes = 32;

}  // namespace

Asset parse_splat(std::string_view bytes, const std::string& path) {
  ELASTOGEN_CHECK_ASSET(!bytes.empty() && bytes.size() % kSplatBytes == 0, path, ": has ",
                        bytes.size(), " bytes, no multiple of the ", kSplatBytes, " of a splat");
  Asset asset;
  asset.path = path;
  asset.format = "splat";
  SplatCloud& splats = asset.splats.emplace();
  ByteReader reader(bytes, path);
  while (reader.left() > 0) {
    const auto vector = [&] {
      const float x = reader.read<float>(), y = reader.read<float>(), z = reader.read<float>();
      return std::array<float, 3>{x, y, z};
    };
    const auto [x, y, z] = vector();
    splats.position.push_back({x, y, z});
    splats.scale.push_back(vector());
    for (int channel = 0; channel < 3; ++channel)
      splats.harmonics.push_back(harmonic_of_colour(reader.read<uint8_t>() / 255.));
    splats.opacity.push_back(float(reader.read<uint8_t>()) / 255);
    for (float& q : splats.rotation.emplace_back()) q = (float(reader.read<uint8_t>()) - 128) / 128;
  }
  return asset;
}

Asset read_splat(const std::string& path) {
  return parse_splat(read_file(path), path);
}

}  // namespace elastogen
