// SPDX-License-Identifier: Apache-2.0
// Images that colour an asset's materials, still encoded, and how they lie on its surface.

#pragma once

#include "io/asset.hpp"
#include "io/gltf_source.hpp"

namespace elastogen {

/// An image file as it is: PNG, JPEG, WebP or anything else.
struct EncodedImage {
  std::string name;  ///< for messages
  Bytes bytes;
};

/// What an image shows beyond 0 ... 1.
enum class Wrap : uint8_t { kRepeat, kClamp, kMirror };

/// What becomes of the surface where its alpha is below 1.
enum class AlphaMode : uint8_t { kOpaque, kMask, kBlend };

/// What colours a material beside its factor (AssetMaterial::base_colour).
struct BaseColour {
  int image = -1;  ///< index into BaseColours::images, -1 for none
  AlphaMode alpha = AlphaMode::kOpaque;
  float cutoff = 0.5f;  ///< kMask: what has less alpha is not there
  std::array<Wrap, 2> wrap = {};
  std::array<float, 6> transform = {1, 0, 0, 0, 1, 0};  ///< row-major 2 x 3, of (u, v, 1)
};

struct BaseColours {
  std::vector<BaseColour> materials;  ///< of each of the asset's materials
  std::vector<EncodedImage> images;   ///< those that are used, each once
  std::vector<std::string> notes;     ///< sentences about images that are not there or not used
};

/// The images of an asset's materials: of glTF its base colour textures (buffer views, data URIs,
/// files beside it; KHR_texture_transform, EXT_texture_webp), else AssetMaterial::texture.
/// @throws Error (asset) as read_gltf_source where the file has changed since it was read.
BaseColours base_colours(const Asset& asset);

}  // namespace elastogen
