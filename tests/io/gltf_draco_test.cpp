// SPDX-License-Identifier: Apache-2.0
#include "core/error.hpp"
#include "io/glb_document.hpp"
#include "io/gltf_reader.hpp"
#include "tests/io/glb_files.hpp"

#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>

#include <algorithm>
#include <random>

namespace elastogen {
namespace {

using test::Builder, test::error_of, test::expect_says, test::Json;

/// A square of n x n cells of two triangles each in the plane z = 3, packed by libdraco's encoder.
struct Packed {
  std::string bytes;
  size_t vertices = 0, triangles = 0;
};

/// A mesh as Draco packs it. @param bits  of positions and UVs; 0: whole floats.
Packed packed(const draco::Mesh& mesh, int method, int bits) {
  draco::Encoder encoder;
  encoder.SetEncodingMethod(method);
  if (bits > 0) {
    encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, bits);
    encoder.SetAttributeQuantization(draco::GeometryAttribute::TEX_COORD, bits);
  }
  draco::EncoderBuffer buffer;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(mesh, &buffer).ok());
  return {std::string(buffer.data(), buffer.size()), mesh.num_points(), mesh.num_faces()};
}

/// @param bits  of quantized positions and UVs, 0 for floats.
/// @param spare  bytes of one more attribute of each vertex, all zero.
Packed packed_square(int n, int method = draco::MESH_EDGEBREAKER_ENCODING, int8_t spare = 0,
                     int bits = 0) {
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(2 * n * n);
  const int position =
      builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  const int uv = builder.AddAttribute(draco::GeometryAttribute::TEX_COORD, 2, draco::DT_FLOAT32);
  const int zero =
      spare == 0 ? -1
                 : builder.AddAttribute(draco::GeometryAttribute::GENERIC, spare, draco::DT_UINT8);
  const std::vector<uint8_t> zeros(size_t(spare), 0);
  // two triangles a cell
  int face = 0;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const std::array<std::array<float, 3>, 4> p = {{{float(i), float(j), 3},
                                                      {float(i + 1), float(j), 3},
                                                      {float(i + 1), float(j + 1), 3},
                                                      {float(i), float(j + 1), 3}}};
      for (const std::array<size_t, 3>& c : {std::array<size_t, 3>{0, 1, 2}, {0, 2, 3}}) {
        const draco::FaceIndex f(static_cast<uint32_t>(face++));
        builder.SetAttributeValuesForFace(position, f, p[c[0]].data(), p[c[1]].data(),
                                          p[c[2]].data());
        builder.SetAttributeValuesForFace(uv, f, p[c[0]].data(), p[c[1]].data(), p[c[2]].data());
        if (zero >= 0)
          builder.SetAttributeValuesForFace(zero, f, zeros.data(), zeros.data(), zeros.data());
      }
    }
  }
  return packed(*builder.Finalize(), method, bits);
}

/// A document whose only primitive is packed; accessors 0 and 1 are POSITION and TEXCOORD_0, 2 are
/// the indices.
Builder file_of(const Packed& packed) {
  Builder builder;
  const int view = builder.add_view(packed.bytes);
  const size_t vertices = packed.vertices, corners = 3 * packed.triangles;
  builder.document["accessors"] = {
      {{"componentType", 5126}, {"count", vertices}, {"type", "VEC3"}, {"min", {7, 7, 7}}},
      {{"componentType", 5126}, {"count", vertices}, {"type", "VEC2"}},
      {{"componentType", 5123}, {"count", corners}, {"type", "SCALAR"}}};
  builder.document["meshes"][0]["name"] = "square";
  builder.add_primitive(
      {{"attributes", {{"POSITION", 0}, {"TEXCOORD_0", 1}}},
       {"indices", 2},
       {"extensions",
        {{"KHR_draco_mesh_compression",
          {{"bufferView", view}, {"attributes", {{"POSITION", 0}, {"TEXCOORD_0", 1}}}}}}}});
  builder.document["nodes"] = Json::array({{{"mesh", 0}}});
  builder.document["extensionsUsed"] = {"KHR_draco_mesh_compression"};
  builder.document["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  return builder;
}

class GltfDraco : public ::testing::Test {
 protected:
  Asset read(const Builder& builder) { return read_gltf(folder.write("a.glb", builder.file())); }
  std::string refusal(const Builder& builder) {
    return error_of([&] { read(builder); });
  }
  /// Reads a file that may be broken; counts refusals, anything but an Error of the asset fails.
  bool is_refused(const Builder& builder) {
    try {
      read(builder);
      return false;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kAsset) << error.what();
      return true;
    }
  }
  test::TempFolder folder;
};

TEST_F(GltfDraco, ReadsWhatWasPacked) {
  for (const int method : {draco::MESH_EDGEBREAKER_ENCODING, draco::MESH_SEQUENTIAL_ENCODING}) {
    const Builder builder = file_of(packed_square(3, method));
    const Asset asset = read(builder);
    const Mesh& mesh = asset.meshes.at(0);
    ASSERT_EQ(mesh.position.size(), 16u);
    ASSERT_EQ(mesh.uv.size(), 16u);
    // every corner of the lattice once, UVs are its x and y
    std::vector<Vec3> found = mesh.position, wanted;
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) wanted.push_back({double(i), double(j), 3});
    }
    std::sort(found.begin(), found.end());
    EXPECT_EQ(found, wanted);
    for (size_t v = 0; v < 16; ++v) {
      EXPECT_EQ(double(mesh.uv[v][0]), mesh.position[v][0]);
      EXPECT_EQ(double(mesh.uv[v][1]), mesh.position[v][1]);
    }
    // 18 triangles of area 1/2 that all look up
    ASSERT_EQ(mesh.groups.at(0).corner.size(), 54u);
    for (size_t t = 0; t < 54; t += 3) {
      const auto at = [&](size_t c) { return mesh.position[size_t(mesh.groups[0].corner[t + c])]; };
      const Vec3 a = at(0), b = at(1), c = at(2);
      EXPECT_EQ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]), 1);
    }
  }
}

/// Fields move when one is added; a sanitizer sees who still looks where they were.
TEST_F(GltfDraco, ReadsPrimitivesWithoutModeHoweverManyOtherFieldsTheyHave) {
  Builder builder = file_of(packed_square(3));
  const std::vector<Vec3> wanted = read(builder).meshes.at(0).position;
  for (const char* field : {"a", "b", "c", "d", "e", "f"}) {
    builder.document["meshes"][0]["primitives"][0][field] = true;
    const Asset asset = read(builder);
    EXPECT_EQ(asset.meshes.at(0).position, wanted);
    const Json plain = Json::parse(gltf_document(asset).json);
    EXPECT_FALSE(plain["meshes"][0]["primitives"][0].contains("extensions"));
  }
}

TEST_F(GltfDraco, TakesTheDensestStreams) {
  const Packed packed = packed_square(256, draco::MESH_EDGEBREAKER_ENCODING, 0, 8);
  EXPECT_GT(packed.triangles, 3 * packed.bytes.size());
  EXPECT_EQ(read(file_of(packed)).meshes.at(0).position.size(), 257u * 257u);
}

TEST_F(GltfDraco, RefusesManyAttributesThatNobodyAsksFor) {
  const int method = draco::MESH_SEQUENTIAL_ENCODING;
  EXPECT_NO_THROW(read(file_of(packed_square(1, method, 40))));
  // 12 + 8 + 100 bytes a vertex; the accessors allow for 8 (3 + 2) and 64 more
  expect_says(refusal(file_of(packed_square(1, method, 100))), "does not hold");
}

TEST_F(GltfDraco, RefusesMoreAttributesThanCountsCanHold) {
  // 24 bytes each by their accessor, 2^16 at most
  Builder builder = file_of(packed_square(1));
  Json& primitive = builder.document["meshes"][0]["primitives"][0];
  for (int k = 0; k < 2800; ++k) {
    const std::string name = "_A" + std::to_string(k);
    primitive["attributes"][name] = 0;
    primitive["extensions"]["KHR_draco_mesh_compression"]["attributes"][name] = 0;
  }
  expect_says(refusal(builder), "more attributes than any real file");
}

TEST_F(GltfDraco, LeavesAPlainDocument) {
  const GlbDocument plain = gltf_document(read(file_of(packed_square(2))));
  const Json document = Json::parse(plain.json);
  EXPECT_FALSE(document.contains("extensionsUsed"));
  EXPECT_FALSE(document.contains("extensionsRequired"));
  const Json& primitive = document["meshes"][0]["primitives"][0];
  EXPECT_FALSE(primitive.contains("extensions"));
  EXPECT_EQ(primitive["attributes"], Json({{"POSITION", 0}, {"TEXCOORD_0", 1}}));
  EXPECT_EQ(document["accessors"][0]["min"], Json({0, 0, 3}));
  EXPECT_EQ(document["accessors"][0]["max"], Json({2, 2, 3}));
  EXPECT_EQ(document["accessors"][2]["count"], 24);
  for (const Json& accessor : document["accessors"]) EXPECT_TRUE(accessor.contains("bufferView"));
}

TEST_F(GltfDraco, SharesWhatPrimitivesShare) {
  Builder builder = file_of(packed_square(2));
  builder.add_primitive(builder.document["meshes"][0]["primitives"][0]);
  const Mesh mesh = read(builder).meshes.at(0);
  EXPECT_EQ(mesh.position.size(), 9u);
  ASSERT_EQ(mesh.groups.size(), 2u);
  EXPECT_EQ(mesh.groups[0].corner, mesh.groups[1].corner);
}

TEST_F(GltfDraco, KeepsTwoStreamsOfOneAccessorApart) {
  Builder builder = file_of(packed_square(2));
  Json second = builder.document["meshes"][0]["primitives"][0];
  const Packed other = packed_square(2, draco::MESH_SEQUENTIAL_ENCODING);
  second["extensions"]["KHR_draco_mesh_compression"]["bufferView"] = builder.add_view(other.bytes);
  builder.add_primitive(second);
  const Mesh mesh = read(builder).meshes.at(0);
  EXPECT_EQ(mesh.position.size(), 18u);
  EXPECT_EQ(mesh.groups.at(1).corner.size(), 24u);
  EXPECT_GE(*std::min_element(mesh.groups[1].corner.begin(), mesh.groups[1].corner.end()), 9);
}

TEST_F(GltfDraco, RefusesWhatDoesNotFitItsAccessors) {
  // one field is changed at a time
  const Packed packed = packed_square(2);
  const auto with = [&](const char* pointer, const Json& value) {
    Builder builder = file_of(packed);
    builder.document[Json::json_pointer(pointer)] = value;
    return refusal(builder);
  };
  const std::string primitive = "/meshes/0/primitives/0",
                    extension = primitive + "/extensions/KHR_draco_mesh_compression";
  const auto in = [&](const char* field, const Json& value) {
    return with((extension + field).c_str(), value);
  };
  // counts and types of accessors
  const std::string vertices = with("/accessors/0/count", 8);
  expect_says(vertices, "meshes[0] (\"square\").primitives[0]");
  Builder fewer = file_of(packed);
  fewer.document["accessors"][0]["count"] = fewer.document["accessors"][1]["count"] = 8;
  expect_says(refusal(fewer), "does not hold what its accessors state");
  expect_says(with("/accessors/2/count", 21), "does not hold what its accessors state");
  expect_says(with("/accessors/2/count", 2147483647), "more than its");
  expect_says(with("/accessors/0/type", "VEC2"), "hold no attribute 0 of 2 components");
  expect_says(with("/accessors/0/type", "MAT4"), "scalars or vectors");
  expect_says(with("/accessors/0/componentType", 5130), "component type");
  expect_says(with((primitive + "/indices").c_str(), 99), "accessors[99] does not exist");
  expect_says(with((primitive + "/mode").c_str(), 1), "only triangles");
  // views and the extension
  expect_says(with("/bufferViews/0/byteLength", 1u << 30), "packed bytes leave the buffer");
  expect_says(with("/bufferViews/0/byteOffset", uint64_t{1} << 52), "leave the buffer");
  expect_says(with("/bufferViews/0/buffer", 7), "no buffer 7");
  expect_says(in("", 3), "must have attributes");
  expect_says(in("/bufferView", 99), "bufferViews[99] does not exist");
  expect_says(in("/bufferView", -1), "non-negative");
  expect_says(in("/attributes", Json::array()), "must have attributes");
  expect_says(in("/attributes/POSITION", 77), "hold no attribute 77");
  expect_says(in("/attributes/POSITION", uint64_t{1} << 40), "hold no attribute");
  expect_says(in("/attributes/POSITION", "a"), "non-negative");
  expect_says(in("/attributes/COLOR_0", 1), "COLOR_0");
}

TEST_F(GltfDraco, RefusesEveryTruncation) {
  for (const int method : {draco::MESH_EDGEBREAKER_ENCODING, draco::MESH_SEQUENTIAL_ENCODING}) {
    Packed packed = packed_square(2, method);
    const std::string whole = packed.bytes;
    for (size_t size = 0; size < whole.size(); ++size) {
      packed.bytes = whole.substr(0, size);
      expect_says(refusal(file_of(packed)), "primitives[0]");
    }
  }
}

TEST_F(GltfDraco, SurvivesDamagedBytes) {
  for (const int method : {draco::MESH_EDGEBREAKER_ENCODING, draco::MESH_SEQUENTIAL_ENCODING}) {
    Packed packed = packed_square(4, method);
    const std::string whole = packed.bytes;
    int refused = 0;
    for (uint32_t seed = 0; seed < 100; ++seed) {
      std::mt19937 random(seed);
      packed.bytes = whole;
      for (uint32_t flips = 0; flips <= seed % 4; ++flips)
        packed.bytes[random() % whole.size()] ^= char(1 << random() % 8);
      refused += is_refused(file_of(packed));
    }
    EXPECT_GT(refused, 10);
  }
}

/// A stream that claims 2^31 - 1 triangles and vertices and ends there (the bytes of the format).
TEST_F(GltfDraco, RefusesAClaimWithoutBytes) {
  const std::string huge = "\x87\xff\xff\xff\x7f";  // 2^31 - 1, most significant seven bits first
  for (const int method : {0, 1}) {
    Packed packed;
    packed.bytes = std::string("DRACO\x02\x02\x01", 8) + char(method) + std::string(2, '\0');
    if (method == 1) packed.bytes += '\0';
    packed.bytes += huge + huge + std::string(64, '\x01');
    packed.vertices = packed.triangles = 4;
    expect_says(refusal(file_of(packed)), "does not hold what its accessors state");
    packed.vertices = 2147483647;
    packed.triangles = 715827882;
    expect_says(refusal(file_of(packed)), "more than its");
  }
}

TEST_F(GltfDraco, RefusesPointCloudsAndOtherVersions) {
  Packed packed = packed_square(1);
  packed.bytes[7] = 0;
  expect_says(refusal(file_of(packed)), "no mesh of Draco 2.2");
  packed.bytes[7] = 1;
  packed.bytes[6] = 9;
  expect_says(refusal(file_of(packed)), "no mesh of Draco 2.2");
  packed.bytes = "not Draco at all";
  expect_says(refusal(file_of(packed)), "no mesh of Draco 2.2");
}

}  // namespace
}  // namespace elastogen
