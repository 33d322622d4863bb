// SPDX-License-Identifier: Apache-2.0
// Custom attributes of glTF files.
#include "io/gltf_reader.hpp"
#include "tests/io/glb_files.hpp"

#include <cmath>

namespace elastogen {
namespace {

using test::Builder, test::error_of, test::expect_says, test::Json, test::triangle;

/// The asset with its custom attributes.
Asset with_attributes(const std::string& path) {
  ReadOptions options;
  options.attributes = true;
  return read_gltf(path, options);
}

TEST(GltfAttributes, ReadsCustomAttributesIfTheyAreAskedFor) {
  const test::TempFolder folder;
  Builder builder = triangle();
  Json& first = builder.document["meshes"][0]["primitives"][0];
  first["attributes"]["_WEIGHT"] = builder.add<float>({0.25f, 0.5f, 1}, "SCALAR", 5126, 3);
  const int pair = builder.add<uint8_t>({255, 0, 0, 51, 0, 0}, "VEC2", 5121, 3);
  builder.document["accessors"][size_t(pair)]["normalized"] = true;
  const int other = builder.add_vectors({5, 0, 0, 6, 0, 0, 5, 1, 0});
  builder.add_primitive({{"attributes", {{"POSITION", other}, {"_MASK", pair}}}, {"indices", 3}});
  const std::string path = folder.write("a.glb", builder.file());
  EXPECT_TRUE(read_gltf(path).meshes[0].attributes.empty());
  const Asset asset = with_attributes(path);
  const std::vector<OwnColumn>& columns = asset.meshes[0].attributes;
  ASSERT_EQ(columns.size(), 3u);
  // NaN where a primitive has none
  const double none = std::numeric_limits<double>::quiet_NaN();
  const std::pair<const char*, std::vector<double>> expected[] = {
      {"_WEIGHT", {0.25, 0.5, 1, none, none, none}},
      {"_MASK.x", {none, none, none, 1, 0, 0}},
      {"_MASK.y", {none, none, none, 0, 0.2, 0}}};
  for (size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(columns[k].name, expected[k].first);
    ASSERT_EQ(columns[k].value.size(), 6u);
    for (size_t v = 0; v < 6; ++v)
      if (std::isnan(expected[k].second[v]))
        EXPECT_TRUE(std::isnan(columns[k].value[v]));
      else
        EXPECT_EQ(columns[k].value[v], expected[k].second[v]);
  }
}

TEST(GltfAttributes, RefusesCustomAttributesThatDoNotFit) {
  const test::TempFolder folder;
  Builder builder = triangle();
  Json& attributes = builder.document["meshes"][0]["primitives"][0]["attributes"];
  attributes["_W"] = builder.add<float>({0, 1}, "SCALAR", 5126, 2);
  const auto refused = [&] {
    const std::string path = folder.write("a.glb", builder.file());
    return error_of([&] { with_attributes(path); });
  };
  expect_says(refused(), "has 2 vertices, its POSITION has 3");
  // a small file whose attributes all name one accessor
  builder = triangle();
  const int one = builder.add<float>({0, 1, 2}, "SCALAR", 5126, 3);
  for (int k = 0; k < 5000; ++k)
    builder.document["meshes"][0]["primitives"][0]["attributes"][concat("_W", k)] = one;
  expect_says(refused(), "used more often than any real file does");
}

}  // namespace
}  // namespace elastogen
