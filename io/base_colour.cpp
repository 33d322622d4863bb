// SPDX-License-Identifier: Apache-2.0
#include "io/base_colour.hpp"

#include "core/error.hpp"
#include "io/safe_file.hpp"

#include <nlohmann/json.hpp>

#include <cmath>
#include <map>

namespace elastogen {
namespace {

using Value = nlohmann::json;

constexpr int64_t kMaxImageBytes = int64_t{1} << 28;

/// Member of an object, null where there is none.
const Value& member(const Value& value, const char* key) {
  static const Value none;
  const auto found = value.is_object() ? value.find(key) : value.end();
  return value.is_object() && found != value.end() ? *found : none;
}

const Value& item(const Value& list, const Value& index) {
  static const Value none;
  const bool there =
      list.is_array() && index.is_number_unsigned() && index.get<uint64_t>() < list.size();
  return there ? list[index.get<size_t>()] : none;
}

double number_or(const Value& value, double otherwise) {
  const double number = value.is_number() ? value.get<double>() : otherwise;
  return std::isfinite(number) ? number : otherwise;
}

double number_at(const Value& list, size_t index, double otherwise) {
  return list.is_array() && index < list.size() ? number_or(list[index], otherwise) : otherwise;
}

Wrap wrap_of(const Value& mode) {
  return mode == 33071 ? Wrap::kClamp : mode == 33648 ? Wrap::kMirror : Wrap::kRepeat;
}

/// offset + rotation scale (u, v) of KHR_texture_transform, as a matrix.
std::array<float, 6> transform_of(const Value& extension) {
  const double angle = number_or(member(extension, "rotation"), 0);
  const double c = std::cos(angle), s = std::sin(angle);
  const Value &scale = member(extension, "scale"), &offset = member(extension, "offset");
  const double x = number_at(scale, 0, 1), y = number_at(scale, 1, 1);
  return {float(c * x),  float(s * y), float(number_at(offset, 0, 0)),
          float(-s * x), float(c * y), float(number_at(offset, 1, 0))};
}

class GltfColours {
 public:
  GltfColours(const Asset& asset, BaseColours& result)
      : source_(read_gltf_source(asset.path)),
        document_(Value::parse(source_.json)),
        result_(result) {}

  void read() {
    const Value& materials = member(document_, "materials");
    for (size_t m = 0; m < result_.materials.size(); ++m)
      read_material(item(materials, m), result_.materials[m]);
  }

 private:
  void read_material(const Value& from, BaseColour& colour) {
    const Value& mode = member(from, "alphaMode");
    if (mode == "MASK") colour.alpha = AlphaMode::kMask;
    if (mode == "BLEND") colour.alpha = AlphaMode::kBlend;
    colour.cutoff = float(number_or(member(from, "alphaCutoff"), 0.5));
    const Value& info = member(member(from, "pbrMetallicRoughness"), "baseColorTexture");
    if (!info.is_object()) return;
    const Value& moved = member(member(info, "extensions"), "KHR_texture_transform");
    const Value& set = moved.contains("texCoord") ? moved["texCoord"] : member(info, "texCoord");
    const Value& texture = item(member(document_, "textures"), member(info, "index"));
    if (number_or(set, 0) != 0) {
      result_.notes.push_back(concat("material \"", member(from, "name"),
                                     "\": its texture lies on other than the first coordinates; "
                                     "its base colour is shown"));
      return;
    }
    colour.transform = transform_of(moved);
    const Value& sampler = item(member(document_, "samplers"), member(texture, "sampler"));
    colour.wrap = {wrap_of(member(sampler, "wrapS")), wrap_of(member(sampler, "wrapT"))};
    colour.image = image(image_index(texture));
  }

  /// Index of the PNG or JPEG image, else of the WebP image, else of a format that is not read.
  static const Value& image_index(const Value& texture) {
    const Value& plain = member(texture, "source");
    if (plain.is_number()) return plain;
    const Value& extensions = member(texture, "extensions");
    const Value& webp = member(member(extensions, "EXT_texture_webp"), "source");
    if (webp.is_number()) return webp;
    return member(member(extensions, "KHR_texture_basisu"), "source");
  }

  /// Index among the images of the result, -1 where there are no bytes.
  int image(const Value& index) {
    const Value& from = item(member(document_, "images"), index);
    if (!from.is_object()) return -1;
    const auto [found, is_new] = image_of_.try_emplace(index.get<size_t>(), -1);
    if (!is_new) return found->second;
    EncodedImage image{concat("images[", index.get<size_t>(), ']'), {}};
    const Value &name = member(from, "name"), &uri = member(from, "uri");
    if (name.is_string()) image.name += concat(" (", name.get<std::string>(), ')');
    try {
      image.bytes = uri.is_string()
                        ? read_gltf_uri(source_.path, uri.get<std::string>(), image.name)
                        : view(member(from, "bufferView"));
    } catch (const Error& error) {
      result_.notes.push_back(concat(error.what(), "; its base colour is shown"));
      return -1;
    }
    result_.images.push_back(std::move(image));
    return found->second = int(result_.images.size()) - 1;
  }

  Bytes view(const Value& index) const {
    const Value& view = item(member(document_, "bufferViews"), index);
    const Value& buffer = member(view, "buffer");
    const double offset = number_or(member(view, "byteOffset"), 0);
    const double length = number_or(member(view, "byteLength"), -1);
    const bool there =
        buffer.is_number_unsigned() && buffer.get<uint64_t>() < source_.buffers.size();
    ELASTOGEN_CHECK_ASSET(there, source_.path, ": an image has no bytes");
    const Bytes& bytes = source_.buffers[buffer.get<size_t>()];
    ELASTOGEN_CHECK_ASSET(offset >= 0 && length >= 0 && offset + length <= double(bytes.size()),
                          source_.path, ": an image lies beyond the bytes of the file");
    return Bytes(bytes.begin() + int64_t(offset), bytes.begin() + int64_t(offset + length));
  }

  GltfSource source_;
  Value document_;
  BaseColours& result_;
  std::map<size_t, int> image_of_;
};

/// Reads textures that lie beside the asset.
void read_files(const Asset& asset, BaseColours& result) {
  std::map<std::string, int> image_of;
  for (size_t m = 0; m < asset.materials.size(); ++m) {
    const AssetMaterial& material = asset.materials[m];
    BaseColour& colour = result.materials[m];
    if (material.base_colour[3] < 1) colour.alpha = AlphaMode::kBlend;
    if (material.texture.empty()) continue;
    const auto [found, is_new] = image_of.try_emplace(material.texture, -1);
    if (is_new) try {
        const std::string text = read_file(material.texture, kMaxImageBytes);
        result.images.push_back({material.texture, Bytes(text.begin(), text.end())});
        found->second = int(result.images.size()) - 1;
      } catch (const Error& error) {
        result.notes.push_back(concat(error.what(), "; its base colour is shown"));
      }
    colour.image = found->second;
  }
}

}  // namespace

BaseColours base_colours(const Asset& asset) {
  BaseColours result;
  result.materials.resize(asset.materials.size());
  if (asset.format == "glb" || asset.format == "gltf")
    GltfColours(asset, result).read();
  else
    read_files(asset, result);
  return result;
}

}  // namespace elastogen
