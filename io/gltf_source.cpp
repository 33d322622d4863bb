// SPDX-License-Identifier: Apache-2.0
#include "io/gltf_source.hpp"

#include "core/error.hpp"
#include "io/json_text.hpp"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <fstream>
#include <set>

namespace elastogen {

namespace {

using nlohmann::json;

constexpr uint32_t kMagic = 0x46546C67, kJsonChunk = 0x4E4F534A, kBinChunk = 0x004E4942;
constexpr uint64_t kMaxFile = uint64_t(1) << 32, kMaxJson = uint64_t(1) << 28;
constexpr int kMaxDepth = 128;

/// The parts of the container before buffers are resolved.
struct Chunks {
  std::string json;
  Bytes bin;
};

uint32_t read_u32(std::ifstream& file) {
  uint8_t b[4] = {};
  file.read(reinterpret_cast<char*>(b), 4);
  return uint32_t(b[0]) | uint32_t(b[1]) << 8 | uint32_t(b[2]) << 16 | uint32_t(b[3]) << 24;
}

template <class Block>
void read_block(std::ifstream& file, uint64_t size, Block& block) {
  block.resize(size);
  file.read(reinterpret_cast<char*>(block.data()), std::streamsize(size));
}

/// Chunks of a GLB file of `size` bytes, read behind the magic number.
Chunks read_glb(std::ifstream& file, uint64_t size, const std::string& path) {
  // the header
  ELASTOGEN_CHECK_ASSET(size >= 20, path, ": the GLB file ends inside its header");
  const uint32_t version = read_u32(file), length = read_u32(file);
  ELASTOGEN_CHECK_ASSET(version == 2, path, ": GLB version ", version, " is not read; only 2 is");
  ELASTOGEN_CHECK_ASSET(length <= size, path, ": the GLB file is truncated: its header states ",
                        length, " bytes, ", size, " are there");
  Chunks chunks;
  // chunks: JSON first, then at most one block of bytes; others are passed over
  uint64_t at = 12;
  for (int index = 0; at + 8 <= length; ++index) {
    const uint32_t chunk = read_u32(file), type = read_u32(file);
    at += 8;
    ELASTOGEN_CHECK_ASSET(chunk <= length - at, path, ": chunk ", index, " of the GLB file states ",
                          chunk, " bytes, ", length - at, " are there");
    ELASTOGEN_CHECK_ASSET((index == 0) == (type == kJsonChunk), path,
                          ": the GLB file must begin with its only JSON chunk");
    ELASTOGEN_CHECK_ASSET(index > 0 || chunk <= kMaxJson, path,
                          ": the JSON is larger than 256 MiB");
    if (index == 0) {
      read_block(file, chunk, chunks.json);
      // writers pad JSON with zero bytes
      while (!chunks.json.empty() && chunks.json.back() == '\0') chunks.json.pop_back();
    } else if (index == 1 && type == kBinChunk) {
      read_block(file, chunk, chunks.bin);
    } else {
      file.seekg(chunk, std::ios::cur);
    }
    at += chunk;
  }
  ELASTOGEN_CHECK_ASSET(file, path, ": reading the GLB file failed");
  return chunks;
}

Chunks read_container(const std::string& path) {
  std::error_code error;
  ELASTOGEN_CHECK_ASSET(std::filesystem::is_regular_file(path, error), path,
                        ": there is no such file");
  const uint64_t size = std::filesystem::file_size(path, error);
  std::ifstream file(path, std::ios::binary);
  ELASTOGEN_CHECK_ASSET(!error && file, path, ": the file cannot be read");
  ELASTOGEN_CHECK_ASSET(size >= 4 && size < kMaxFile, path,
                        ": a glTF file has 4 bytes to 4 GiB, this one has ", size);
  if (read_u32(file) == kMagic) return read_glb(file, size, path);
  ELASTOGEN_CHECK_ASSET(size <= kMaxJson, path, ": the JSON is larger than 256 MiB");
  Chunks chunks;
  file.seekg(0);
  read_block(file, size, chunks.json);
  ELASTOGEN_CHECK_ASSET(file, path, ": reading the file failed");
  return chunks;
}

/// @throws Error if brackets are nested too deeply for recursive parsers.
void check_depth(const std::string& text, const std::string& path) {
  int depth = 0;
  bool quoted = false;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted) {
      if (c == '\\') ++i;
      quoted = c != '"';
    } else if (c == '"') {
      quoted = true;
    } else if (c == '[' || c == '{') {
      ++depth;
      ELASTOGEN_CHECK_ASSET(depth <= kMaxDepth, path, ": the JSON is nested deeper than ",
                            kMaxDepth, " levels");
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
}

json parse(const std::string& text, const std::string& path) {
  try {
    json document = parsed_sorted_json(text);
    ELASTOGEN_CHECK_ASSET(document.is_object(), path, ": the JSON is not an object");
    return document;
  } catch (const json::exception& failure) {
    throw Error(path + ": malformed JSON: " + failure.what(), ErrorKind::kAsset);
  }
}

/// Whether the extension is resolved by plain_gltf, or changes neither geometry nor the node tree
/// and is kept as it is.
bool is_known(const std::string& name) {
  static const std::set<std::string> kNames = {"EXT_mesh_gpu_instancing",
                                               "EXT_meshopt_compression",
                                               "EXT_texture_avif",
                                               "EXT_texture_webp",
                                               "KHR_draco_mesh_compression",
                                               "KHR_lights_punctual",
                                               "KHR_mesh_quantization",
                                               "KHR_node_visibility",
                                               "KHR_texture_basisu",
                                               "KHR_texture_transform",
                                               "KHR_xmp_json_ld",
                                               "MSFT_texture_dds"};
  return name.starts_with("KHR_materials_") || kNames.contains(name);
}

/// @throws Error on a required extension that is not known.
void check_extensions(const json& document, const std::string& path) {
  for (const char* list : {"extensionsUsed", "extensionsRequired"}) {
    const json names = document.value(list, json::array());
    ELASTOGEN_CHECK_ASSET(names.is_array(), path, ": \"", list, "\" is not an array");
    for (const json& entry : names) {
      ELASTOGEN_CHECK_ASSET(entry.is_string(), path, ": \"", list, "\" holds more than names");
      const std::string& name = entry.get_ref<const std::string&>();
      const bool known = list == std::string("extensionsUsed") || is_known(name);
      ELASTOGEN_CHECK_ASSET(known, path, ": requires the extension ", name,
                            ", which is not read; re-export without it");
    }
  }
}

/// Whether a buffer only stands in for data of EXT_meshopt_compression; it may lack bytes.
bool is_fallback(const json& buffer) {
  const json::json_pointer flag("/extensions/EXT_meshopt_compression/fallback");
  return buffer.is_object() && buffer.contains(flag) && buffer[flag] == true;
}

/// Bytes of buffer `index`, cut to its stated length; none for a fallback.
Bytes resolve_buffer(const json& buffer, size_t index, Chunks& chunks, const std::string& path) {
  const std::string what = concat("buffers[", index, "]");
  const std::string place = path + ": " + what;
  ELASTOGEN_CHECK_ASSET(buffer.is_object() && buffer.contains("byteLength") &&
                            buffer["byteLength"].is_number_unsigned(),
                        place, ": byteLength is missing or not a count");
  const uint64_t length = buffer["byteLength"].get<uint64_t>();
  if (is_fallback(buffer)) return {};
  Bytes bytes;
  if (buffer.contains("uri")) {
    ELASTOGEN_CHECK_ASSET(buffer["uri"].is_string(), place, ": the URI is not a string");
    bytes = read_gltf_uri(path, buffer["uri"].get_ref<const std::string&>(), what);
  } else {
    ELASTOGEN_CHECK_ASSET(index == 0, place, ": there are no bytes for this buffer");
    bytes = std::move(chunks.bin);
  }
  ELASTOGEN_CHECK_ASSET(length <= bytes.size(), place, ": byteLength is ", length, " but only ",
                        bytes.size(), " bytes are there");
  bytes.resize(length);
  return bytes;
}

}  // namespace

GltfSource read_gltf_source(const std::string& path) {
  Chunks chunks = read_container(path);
  check_depth(chunks.json, path);
  const json document = parse(chunks.json, path);
  check_extensions(document, path);
  GltfSource source{path, std::move(chunks.json), {}};
  if (!document.contains("buffers")) return source;
  const json& buffers = document["buffers"];
  ELASTOGEN_CHECK_ASSET(buffers.is_array(), path, ": \"buffers\" is not an array");
  uint64_t total = 0;
  for (const json& buffer : buffers) {
    source.buffers.push_back(resolve_buffer(buffer, source.buffers.size(), chunks, path));
    total += source.buffers.back().size();
    ELASTOGEN_CHECK_ASSET(total < kMaxFile, path, ": the buffers hold more than 4 GiB");
  }
  return source;
}

}  // namespace elastogen
