// SPDX-License-Identifier: Apache-2.0
#include "core/error.hpp"
#include "io/glb_document.hpp"
#include "io/gltf_reader.hpp"
#include "tests/io/glb_files.hpp"

#include <meshoptimizer.h>

#include <cmath>
#include <random>

namespace elastogen {
namespace {

using test::Builder, test::error_of, test::expect_says, test::Json, test::triangle;

std::string packed_vertices(const std::string& bytes, size_t stride) {
  const size_t count = bytes.size() / stride;
  std::string packed(meshopt_encodeVertexBufferBound(count, stride), '\0');
  packed.resize(meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char*>(packed.data()),
                                           packed.size(), bytes.data(), count, stride));
  return packed;
}

std::string packed_triangles(const std::vector<unsigned>& indices, size_t vertices) {
  std::string packed(meshopt_encodeIndexBufferBound(indices.size(), vertices), '\0');
  packed.resize(meshopt_encodeIndexBuffer(reinterpret_cast<unsigned char*>(packed.data()),
                                          packed.size(), indices.data(), indices.size()));
  return packed;
}

std::string packed_sequence(const std::vector<unsigned>& indices, size_t vertices) {
  std::string packed(meshopt_encodeIndexSequenceBound(indices.size(), vertices), '\0');
  packed.resize(meshopt_encodeIndexSequence(reinterpret_cast<unsigned char*>(packed.data()),
                                            packed.size(), indices.data(), indices.size()));
  return packed;
}

/// A document with buffer 1 that has no bytes, whose views are packed in buffer 0.
struct PackedBuilder : Builder {
  /// @return index of the view.
  int add_packed(const std::string& packed, size_t count, size_t stride, const char* mode) {
    const int raw = add_view(packed);
    Json& view = document["bufferViews"][size_t(raw)];
    const size_t offset = view["byteOffset"];
    view = {{"buffer", 1},
            {"byteOffset", 0},
            {"byteLength", count * stride},
            {"extensions",
             {{"EXT_meshopt_compression",
               {{"buffer", 0},
                {"byteOffset", offset},
                {"byteLength", packed.size()},
                {"byteStride", stride},
                {"count", count},
                {"mode", mode}}}}}};
    return raw;
  }
  int add_accessor(int view, int component, size_t count, const char* type) {
    document["accessors"].push_back(
        {{"bufferView", view}, {"componentType", component}, {"count", count}, {"type", type}});
    return int(document["accessors"].size()) - 1;
  }
  std::string file() const {
    Json complete = document;
    complete["buffers"] = {{{"byteLength", bin.size()}},
                           {{"byteLength", 1000},
                            {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}}};
    return test::glb(complete, bin);
  }
};

/// A square of four vertices and two triangles; the indices as TRIANGLES of two bytes.
PackedBuilder square() {
  PackedBuilder builder;
  const std::vector<float> position = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0.5};
  const int vertices =
      builder.add_packed(packed_vertices(test::bytes_of(position), 12), 4, 12, "ATTRIBUTES");
  builder.document["bufferViews"][size_t(vertices)]["byteStride"] = 12;
  const int corners =
      builder.add_packed(packed_triangles({0, 1, 2, 0, 2, 3}, 4), 6, 2, "TRIANGLES");
  const int p = builder.add_accessor(vertices, 5126, 4, "VEC3");
  const int i = builder.add_accessor(corners, 5123, 6, "SCALAR");
  builder.add_primitive({{"attributes", {{"POSITION", p}}}, {"indices", i}});
  builder.document["nodes"] = Json::array({{{"mesh", 0}}});
  builder.document["extensionsUsed"] = {"EXT_meshopt_compression"};
  builder.document["extensionsRequired"] = {"EXT_meshopt_compression"};
  return builder;
}

class GltfMeshopt : public ::testing::Test {
 protected:
  Asset read(const PackedBuilder& builder) {
    return read_gltf(folder.write("a.glb", builder.file()));
  }
  std::string refusal(const PackedBuilder& builder) {
    return error_of([&] { read(builder); });
  }
  test::TempFolder folder;
};

TEST_F(GltfMeshopt, ReadsWhatWasPacked) {
  const Mesh mesh = read(square()).meshes.at(0);
  EXPECT_EQ(mesh.position, (std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0.5}}));
  ASSERT_EQ(mesh.groups.at(0).corner.size(), 6u);
  // the codec may turn a triangle's corners, not its winding
  for (const size_t t : {size_t{0}, size_t{3}}) {
    std::vector<int32_t> c(mesh.groups[0].corner.begin() + std::ptrdiff_t(t),
                           mesh.groups[0].corner.begin() + std::ptrdiff_t(t) + 3);
    std::rotate(c.begin(), std::find(c.begin(), c.end(), 0), c.end());
    EXPECT_EQ(c, t == 0 ? (std::vector<int32_t>{0, 1, 2}) : (std::vector<int32_t>{0, 2, 3}));
  }
}

TEST_F(GltfMeshopt, ReadsIndexSequences) {
  PackedBuilder builder = square();
  const int view = builder.add_packed(packed_sequence({3, 0, 1, 3, 1, 2}, 4), 6, 4, "INDICES");
  builder.document["accessors"][1]["bufferView"] = view;
  builder.document["accessors"][1]["componentType"] = 5125;
  EXPECT_EQ(read(builder).meshes.at(0).groups.at(0).corner,
            (std::vector<int32_t>{3, 0, 1, 3, 1, 2}));
}

TEST_F(GltfMeshopt, AppliesFilters) {
  PackedBuilder builder = square();
  // octahedral, 8 bits: x, y, one; the exponential one: exponent in the upper byte, 24-bit mantissa
  const std::vector<int8_t> octahedral = {0, 0,    127, 0, 127, 0,   127, 0,
                                          0, -127, 127, 0, 0,   127, 127, 0};
  const int normals =
      builder.add_packed(packed_vertices(test::bytes_of(octahedral), 4), 4, 4, "ATTRIBUTES");
  const auto word = [](int exponent, int mantissa) {
    return uint32_t(exponent) << 24 | (uint32_t(mantissa) & 0xffffffu);
  };
  const std::vector<uint32_t> exponential = {word(-1, 3), word(2, -5), word(0, 0), word(0, 1),
                                             word(-3, 1), word(4, 1),  word(0, 7), word(0, 0)};
  const int uvs =
      builder.add_packed(packed_vertices(test::bytes_of(exponential), 8), 4, 8, "ATTRIBUTES");
  const auto filter = [&](int view, const char* name) {
    Json& v = builder.document["bufferViews"][size_t(view)];
    v["byteStride"] = v["extensions"]["EXT_meshopt_compression"]["byteStride"];
    v["extensions"]["EXT_meshopt_compression"]["filter"] = name;
  };
  filter(normals, "OCTAHEDRAL");
  filter(uvs, "EXPONENTIAL");
  Json& attributes = builder.document["meshes"][0]["primitives"][0]["attributes"];
  attributes["NORMAL"] = builder.add_accessor(normals, 5120, 4, "VEC3");
  builder.document["accessors"].back()["normalized"] = true;
  attributes["TEXCOORD_0"] = builder.add_accessor(uvs, 5126, 4, "VEC2");
  const Mesh mesh = read(builder).meshes.at(0);
  EXPECT_EQ(mesh.normal,
            (std::vector<std::array<float, 3>>{{0, 0, 1}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}}));
  EXPECT_EQ(mesh.uv,
            (std::vector<std::array<float, 2>>{{1.5f, -20}, {0, 1}, {0.125f, 16}, {7, 0}}));
}

TEST_F(GltfMeshopt, LeavesAPlainDocument) {
  const Json document = Json::parse(gltf_document(read(square())).json);
  EXPECT_FALSE(document.contains("extensionsUsed"));
  EXPECT_FALSE(document.contains("extensionsRequired"));
  for (const Json& view : document["bufferViews"]) {
    EXPECT_FALSE(view.contains("extensions"));
    EXPECT_EQ(view["buffer"], 0);
  }
  EXPECT_EQ(document["bufferViews"][0]["byteStride"], 12);
  EXPECT_EQ(document["bufferViews"][0]["byteLength"], 48);
}

TEST_F(GltfMeshopt, RefusesParametersOutOfRange) {
  const auto with = [&](int view, const char* field, const Json& value) {
    PackedBuilder builder = square();
    builder.document["bufferViews"][size_t(view)]["extensions"]["EXT_meshopt_compression"][field] =
        value;
    return refusal(builder);
  };
  // vertices
  expect_says(with(0, "byteStride", 0), "multiple of 4 up to 256");
  expect_says(with(0, "byteStride", 6), "bufferViews[0]");
  expect_says(with(0, "byteStride", 260), "multiple of 4 up to 256");
  expect_says(with(0, "byteStride", -4), "non-negative");
  expect_says(with(0, "mode", "OTHER"), "mode must be");
  expect_says(with(0, "mode", 3), "string");
  expect_says(with(0, "filter", "OTHER"), "filter");
  expect_says(with(0, "filter", "OCTAHEDRAL"), "filter");
  expect_says(with(0, "filter", "QUATERNION"), "filter");
  expect_says(with(0, "count", 2147483648u), "more than its bytes can hold");
  expect_says(with(0, "count", uint64_t{1} << 60), "non-negative integer");
  expect_says(with(0, "count", 3), "count times byteStride");
  expect_says(with(0, "buffer", 1), "leave the buffer");
  expect_says(with(0, "buffer", 2), "no buffer 2");
  expect_says(with(0, "byteOffset", UINT64_MAX - 7), "byteOffset");
  expect_says(with(0, "byteOffset", uint64_t{1} << 52), "leave the buffer");
  expect_says(with(0, "byteLength", 100000), "leave the buffer");
  // indices
  expect_says(with(1, "byteStride", 8), "must be 2 or 4");
  expect_says(with(1, "count", 5), "multiple of 3");
  expect_says(with(1, "count", 2147483646u), "more than its bytes can hold");
  expect_says(with(1, "filter", "EXPONENTIAL"), "no filter");
  expect_says(with(1, "mode", "ATTRIBUTES"), "multiple of 4");
  // an extension that is no object
  PackedBuilder builder = square();
  builder.document["bufferViews"][0]["extensions"]["EXT_meshopt_compression"] = 3;
  expect_says(refusal(builder), "must be an object");
}

TEST_F(GltfMeshopt, RefusesAViewOfAFallbackWithoutBytes) {
  PackedBuilder builder = square();
  builder.document["bufferViews"][0].erase("extensions");
  expect_says(refusal(builder), "leaves the buffer");
}

/// The packed bytes of a view, cut or changed in place.
TEST_F(GltfMeshopt, RefusesEveryTruncation) {
  for (const size_t view : {size_t{0}, size_t{1}}) {
    PackedBuilder builder = square();
    Json& extension =
        builder.document["bufferViews"][view]["extensions"]["EXT_meshopt_compression"];
    const size_t whole = extension["byteLength"];
    for (size_t size = 0; size < whole; ++size) {
      extension["byteLength"] = size;
      expect_says(refusal(builder), concat("bufferViews[", view, ']'));
    }
  }
}

TEST_F(GltfMeshopt, SurvivesDamagedBytes) {
  const PackedBuilder whole = square();
  int refused = 0;
  for (uint32_t seed = 0; seed < 100; ++seed) {
    std::mt19937 random(seed);
    PackedBuilder builder = whole;
    for (uint32_t flips = 0; flips <= seed % 4; ++flips)
      builder.bin[random() % builder.bin.size()] ^= char(1 << random() % 8);
    try {
      read(builder);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kAsset) << error.what();
      ++refused;
    }
  }
  EXPECT_GT(refused, 10);
}

}  // namespace
}  // namespace elastogen
