// SPDX-License-Identifier: Apache-2.0
// Small GLB files for tests, and a reader of GLB files that shares nothing with io.

#pragma once

#include "tests/io/test_files.hpp"

#include <nlohmann/json.hpp>

#include <array>
#include <cstring>
#include <map>
#include <vector>

namespace elastogen::test {

using Json = nlohmann::json;
using Rows = std::vector<std::vector<double>>;

inline std::string u32(uint32_t value) {
  return std::string(reinterpret_cast<const char*>(&value), 4);
}

/// The bytes of values.
template <class T>
std::string bytes_of(const std::vector<T>& values) {
  return std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
}

/// A GLB file of a document and its buffer.
inline std::string glb(const Json& document, std::string bin) {
  std::string text = document.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  bin.resize((bin.size() + 3) / 4 * 4);
  const auto size = uint32_t(28 + text.size() + bin.size());
  return "glTF" + u32(2) + u32(size) + u32(uint32_t(text.size())) + "JSON" + text +
         u32(uint32_t(bin.size())) + std::string("BIN\0", 4) + bin;
}

/// A document under construction.
struct Builder {
  Json document = {{"asset", {{"version", "2.0"}}}};
  std::string bin;

  int add_view(const std::string& bytes) {
    bin.resize((bin.size() + 3) / 4 * 4);
    document["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", bin.size()}, {"byteLength", bytes.size()}});
    bin += bytes;
    return int(document["bufferViews"].size()) - 1;
  }
  template <class T>
  int add(const std::vector<T>& values, const char* type, int component, size_t count) {
    document["accessors"].push_back({{"bufferView", add_view(bytes_of(values))},
                                     {"componentType", component},
                                     {"count", count},
                                     {"type", type}});
    return int(document["accessors"].size()) - 1;
  }
  int add_vectors(const std::vector<float>& values) {
    return add(values, "VEC3", 5126, values.size() / 3);
  }
  int add_primitive(const Json& primitive, size_t mesh = 0) {
    document["meshes"][mesh]["primitives"].push_back(primitive);
    return int(document["meshes"][mesh]["primitives"].size()) - 1;
  }
  std::string file() const {
    Json complete = document;
    complete["buffers"] = Json::array({{{"byteLength", bin.size()}}});
    return glb(complete, bin);
  }
};

/// A triangle (0,0,0) (1,0,0) (0,1,0) with normals, UVs and indices, shown by one node.
inline Builder triangle() {
  Builder builder;
  const int position = builder.add_vectors({0, 0, 0, 1, 0, 0, 0, 1, 0});
  const int normal = builder.add_vectors({0, 0, 1, 0, 0, 1, 0, 0, 1});
  const int uv = builder.add<float>({0, 0, 1, 0, 0, 1}, "VEC2", 5126, 3);
  const int index = builder.add<uint16_t>({0, 1, 2}, "SCALAR", 5123, 3);
  builder.add_primitive(
      {{"attributes", {{"POSITION", position}, {"NORMAL", normal}, {"TEXCOORD_0", uv}}},
       {"indices", index}});
  builder.document["nodes"] = Json::array({{{"name", "leaf"}, {"mesh", 0}}});
  return builder;
}

/// A GLB file as it lies on disk.
struct GlbFile {
  Json document;
  std::string bin;

  explicit GlbFile(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    const std::string all(std::istreambuf_iterator<char>(file), {});
    const auto word = [&](size_t at) {
      uint32_t value = 0;
      if (at + 4 <= all.size()) std::memcpy(&value, all.data() + at, 4);
      return value;
    };
    EXPECT_EQ(all.substr(0, 4), "glTF");
    EXPECT_EQ(word(4), 2u);
    EXPECT_EQ(word(8), all.size());
    const uint32_t json_size = word(12);
    EXPECT_EQ(json_size % 4, 0u);
    document = Json::parse(all.substr(20, json_size));
    const uint32_t bin_size = word(20 + json_size);
    EXPECT_EQ(28 + json_size + bin_size, all.size());
    bin = all.substr(28 + json_size);
  }

  /// The bytes of an accessor without interleaving; of a buffer view.
  std::string view_bytes(size_t view) const {
    const Json& v = document["bufferViews"][view];
    return bin.substr(v.value("byteOffset", size_t{0}), v["byteLength"].get<size_t>());
  }

  /// Rows of a float accessor.
  Rows floats(size_t index) const {
    const Json& accessor = document["accessors"][index];
    const std::map<std::string, size_t> widths = {
        {"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}};
    const size_t width = widths.at(accessor["type"]), count = accessor["count"];
    EXPECT_EQ(accessor["componentType"], 5126);
    Rows rows(count, std::vector<double>(width, 0));
    if (!accessor.contains("bufferView")) return rows;
    const Json& view = document["bufferViews"][accessor["bufferView"].get<size_t>()];
    const size_t start =
        view.value("byteOffset", size_t{0}) + accessor.value("byteOffset", size_t{0});
    const size_t stride = view.value("byteStride", 4 * width);
    EXPECT_EQ(start % 4, 0u);
    EXPECT_LE(accessor.value("byteOffset", size_t{0}) + (count - 1) * stride + 4 * width,
              view["byteLength"].get<size_t>());
    for (size_t r = 0; r < count; ++r) {
      for (size_t c = 0; c < width; ++c) {
        float value = 0;
        std::memcpy(&value, bin.data() + start + r * stride + 4 * c, 4);
        rows[r][c] = value;
      }
    }
    return rows;
  }

  const Json& mesh_of(size_t node) const {
    return document["meshes"][document["nodes"][node]["mesh"].get<size_t>()];
  }

  /// Weights of a node, (frames, targets).
  Rows weights(size_t node) const {
    Rows rows;
    for (const Json& channel : document["animations"][0]["channels"]) {
      if (channel["target"]["node"] != node) continue;
      const Json& sampler = document["animations"][0]["samplers"][channel["sampler"].get<size_t>()];
      const Rows flat = floats(sampler["output"]);
      const size_t frames = document["accessors"][sampler["input"].get<size_t>()]["count"];
      rows.resize(frames);
      for (size_t i = 0; i < flat.size(); ++i)
        rows[i / (flat.size() / frames)].push_back(flat[i][0]);
    }
    return rows;
  }

  /// sum_k w_k target_k of an attribute of a primitive, (vertices, 3).
  Rows moved(const Json& primitive, const std::string& attribute,
             const std::vector<double>& weight) const {
    const size_t accessor = primitive["attributes"][attribute];
    Rows sum(document["accessors"][accessor]["count"], std::vector<double>(3, 0));
    EXPECT_EQ(primitive["targets"].size(), weight.size());
    for (size_t k = 0; k < weight.size(); ++k) {
      const Rows target = floats(primitive["targets"][k][attribute]);
      for (size_t v = 0; v < sum.size(); ++v) {
        for (size_t d = 0; d < 3; ++d) sum[v][d] += weight[k] * target[v][d];
      }
    }
    return sum;
  }
};

}  // namespace elastogen::test
