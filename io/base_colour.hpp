// SPDX-License-Identifier: Apache-2.0
// Images that colour an asset's materials, still encoded, and how they map to its surface.

#pragma once

#include "io/asset.hpp"
#include "io/gltf_source.hpp"

namespace elastogen {

/// An image file as it is: PNG, JPEG, WebP or anything else.
struct EncodedImage {
  std::string name;  ///< for messages
  Bytes bytes;
};

/// Behaviour of an image outside 0 ... 1.
enum class Wrap : uint8_t { kRepeat, kClamp, kMirror };

/// Meaning of an alpha below 1.
enum class AlphaMode : uint8_t { kOpaque, kMask, kBlend };

/// Colouring of a material beside its factor (AssetMaterial::base_colour).
struct BaseColour {
  int image = -1;  ///< index into BaseColours::images, -1 for none
  AlphaMode alpha = AlphaMode::kOpaque;
  float cutoff = 0.5f;  ///< kMask: texels of less alpha are not drawn
  std::array<Wrap, 2> wrap = {};
  std::array<float, 6> transform = {1, 0, 0, 0, 1, 0};  ///< row-major 2 x 3, of (u, v, 1)
};

struct BaseColours {
  std::vector<BaseColour> materials;  ///< of each of the asset's materials
  std::vector<EncodedImage> images;   ///< used images, each once
  std::vector<std::string> notes;     ///< sentences about images that are missing or not used
};

/// The images of an asset's materials. For glTF these are its base colour textures (buffer views,
/// data URIs, files beside it; KHR_texture_transform, EXT_texture_webp), else
/// AssetMaterial::texture.
/// @throws Error (asset) as read_gltf_source if the file has changed since it was read.
BaseColours base_colours(const Asset& asset);

}  // namespace elastogen
