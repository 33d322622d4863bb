// SPDX-License-Identifier: Apache-2.0
#include "io/glb_document.hpp"

#include "core/error.hpp"
#include "io/gltf_animations.hpp"
#include "io/json_text.hpp"
#include "io/plain_gltf.hpp"
#include "io/safe_file.hpp"

#include <nlohmann/json.hpp>

#include <map>
#include <string_view>

namespace elastogen {

namespace {

using Json = nlohmann::ordered_json;

/// A white pixel, for images that are not there.
constexpr uint8_t kWhitePixel[] = {
    0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48,
    0x44, 0x52, 0x00, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x01, 0x08, 0x00, 0x00, 0x00,
    0x00, 0x3a, 0x7e, 0x9b, 0x55, 0x00, 0x00, 0x00, 0x0a, 0x49, 0x44, 0x41, 0x54, 0x78,
    0x9c, 0x63, 0xf8, 0x0f, 0x00, 0x01, 0x01, 0x01, 0x00, 0xb1, 0x38, 0xf6, 0x14, 0x00,
    0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};

/// Joins the buffers and shifts the buffer views accordingly.
void join_buffers(const GltfSource& source, Json& document, Bytes& bin) {
  std::vector<uint64_t> offset;
  for (const Bytes& buffer : source.buffers) {
    offset.push_back(append_bytes(bin, buffer.data(), buffer.size()));
  }
  if (!document.contains("bufferViews")) document["bufferViews"] = Json::array();
  for (Json& view : document["bufferViews"]) {
    const auto buffer = view["buffer"].get<size_t>();
    ELASTOGEN_CHECK_ASSET(buffer < offset.size(), source.path, ": there is no buffer ", buffer);
    if (offset[buffer] > 0) {
      view["byteOffset"] = view.value("byteOffset", uint64_t{0}) + offset[buffer];
    }
    view["buffer"] = 0;
  }
}

/// Embeds the images that lie beside the file.
void embed_images(const GltfSource& source, Json& document, GlbDocument& result) {
  if (!document.contains("images")) return;
  for (size_t i = 0; i < document["images"].size(); ++i) {
    Json& image = document["images"][i];
    const std::string uri = image.value("uri", "");
    if (uri.empty() || is_data_uri(uri)) continue;
    const std::string what = concat("images[", i, ']');
    Bytes bytes(std::begin(kWhitePixel), std::end(kWhitePixel));
    if (resolve_gltf_uri(source.path, uri, what).empty()) {
      result.notes.push_back(uri + " was missing; a white pixel stands for it");
    } else {
      bytes = read_gltf_uri(source.path, uri, what);
    }
    const std::string type = image_type(bytes);
    if (!type.empty()) image["mimeType"] = type;
    image.erase("uri");
    image["bufferView"] = document["bufferViews"].size();
    const uint64_t offset = append_bytes(result.bin, bytes.data(), bytes.size());
    document["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", bytes.size()}});
  }
}

/// Meshes that only simulated nodes show.
std::vector<size_t> simulated_meshes(const Json& document, const std::vector<AssetNode>& nodes) {
  std::map<size_t, bool> only_simulated;
  for (size_t n = 0; n < nodes.size(); ++n) {
    const Json& node = document["nodes"][n];
    if (!node.contains("mesh")) continue;
    const bool simulated = nodes[n].mesh >= 0;
    const auto [at, is_new] = only_simulated.try_emplace(node["mesh"].get<size_t>(), simulated);
    if (!is_new) at->second = at->second && simulated;
  }
  std::vector<size_t> meshes;
  for (const auto& [mesh, only] : only_simulated)
    if (only) meshes.push_back(mesh);
  return meshes;
}

/// Removes everything but the simulation that would move simulated vertices.
void remove_motion(Json& document, const std::vector<AssetNode>& nodes) {
  keep_other_animations(document, nodes);
  for (size_t n = 0; n < nodes.size(); ++n)
    if (nodes[n].mesh >= 0) document["nodes"][n].erase("weights");
  for (const size_t m : simulated_meshes(document, nodes)) {
    Json& mesh = document["meshes"][m];
    mesh.erase("weights");
    if (mesh.contains("extras") && mesh["extras"].is_object()) mesh["extras"].erase("targetNames");
    for (Json& primitive : mesh["primitives"]) primitive.erase("targets");
  }
}

void write_u32(SafeFile& file, uint64_t value) {
  const uint8_t bytes[4] = {uint8_t(value), uint8_t(value >> 8), uint8_t(value >> 16),
                            uint8_t(value >> 24)};
  file.write(bytes, 4);
}

}  // namespace

GlbDocument gltf_document(const Asset& asset) {
  std::vector<Finding> findings;
  const GltfSource source = plain_gltf(read_gltf_source(asset.path), findings);
  GlbDocument result;
  Json document = parsed_json(source.json);
  try {
    join_buffers(source, document, result.bin);
    embed_images(source, document, result);
    ELASTOGEN_CHECK_ASSET(document.value("nodes", Json::array()).size() == asset.nodes.size(),
                          asset.path, ": the asset file changed while it was animated");
    remove_motion(document, asset.nodes);
  } catch (const nlohmann::json::exception& failure) {
    throw Error(asset.path + ": not valid glTF: " + failure.what(), ErrorKind::kAsset);
  }
  result.json = document.dump();
  return result;
}

std::string image_type(const Bytes& image) {
  const std::string_view head(reinterpret_cast<const char*>(image.data()),
                              std::min<size_t>(image.size(), 12));
  if (head.starts_with("\x89PNG")) return "image/png";
  if (head.starts_with("\xff\xd8\xff")) return "image/jpeg";
  if (head.starts_with("RIFF") && head.ends_with("WEBP")) return "image/webp";
  if (head.starts_with("\xabKTX 20")) return "image/ktx2";
  return "";
}

uint64_t append_bytes(Bytes& bin, const void* data, size_t size) {
  bin.resize((bin.size() + 3) / 4 * 4);
  const auto* bytes = static_cast<const uint8_t*>(data);
  const uint64_t offset = bin.size();
  bin.insert(bin.end(), bytes, bytes + size);
  return offset;
}

void write_glb(const std::string& path, const std::string& json, const Bytes& bin) {
  const uint64_t json_size = (json.size() + 3) / 4 * 4, bin_size = (bin.size() + 3) / 4 * 4;
  const uint64_t total = 12 + 8 + json_size + 8 + bin_size;
  if (total > UINT32_MAX) {
    throw Error(concat(path, ": the animation needs ", total,
                       " bytes, a GLB file holds 4 GiB; use "
                       "the modal profile or fewer frames"),
                ErrorKind::kResources);
  }
  SafeFile file(path);
  for (const uint64_t word : {uint64_t{0x46546C67}, uint64_t{2}, total}) write_u32(file, word);
  write_u32(file, json_size);
  write_u32(file, 0x4E4F534A);
  file.write(json + std::string(json_size - json.size(), ' '));
  write_u32(file, bin_size);
  write_u32(file, 0x004E4942);
  file.write(bin.data(), bin.size());
  file.write(std::string(bin_size - bin.size(), '\0'));
  file.commit();
}

}  // namespace elastogen
