// SPDX-License-Identifier: Apache-2.0
#include "io/base_colour.hpp"

#include "io/gltf_reader.hpp"
#include "tests/io/image_files.hpp"
#include "tests/io/test_files.hpp"

namespace elastogen::test {
namespace {

/// A document of materials whose other parts stand in `parts`.
BaseColours colours_of(const TempFolder& folder, const std::string& materials,
                       const std::string& parts = "", size_t count = 1) {
  Asset asset;
  asset.format = "gltf";
  asset.path = folder.write("a.gltf", "{\"asset\": {\"version\": \"2.0\"}, \"materials\": [" +
                                          materials + "]" + parts + "}");
  asset.materials.resize(count);
  return base_colours(asset);
}

std::string textured(const std::string& more = "") {
  return "{\"pbrMetallicRoughness\": {\"baseColorTexture\": {\"index\": 0" + more + "}}}";
}

TEST(BaseColour, OfGltfIsFoundInsideAndBesideTheFile) {
  const TempFolder folder;
  folder.write("skin.png", four_colours());
  const BaseColours beside =
      colours_of(folder, textured(),
                 ", \"textures\": [{\"source\": 0}], \"images\": [{\"uri\": \"skin.png\"}]");
  ASSERT_EQ(beside.images.size(), 1u);
  const Bytes& bytes = beside.images[0].bytes;
  EXPECT_EQ(std::string(bytes.begin(), bytes.end()), four_colours());
  EXPECT_EQ(beside.materials[0].image, 0);
  EXPECT_TRUE(beside.notes.empty());
  const BaseColours inside = colours_of(
      folder, textured() + ", " + textured(),
      ", \"textures\": [{\"extensions\": {\"EXT_texture_webp\": {\"source\": 0}}}], \"images\": "
      "[{\"bufferView\": 0}], \"bufferViews\": [{\"buffer\": 0, \"byteOffset\": 1, \"byteLength\": "
      "3}], \"buffers\": [{\"byteLength\": 6, \"uri\": \"data:;base64,YWJjZGVm\"}]",
      2);
  ASSERT_EQ(inside.images.size(), 1u);  // both materials share it
  EXPECT_EQ(inside.images[0].bytes, (Bytes{'b', 'c', 'd'}));
  EXPECT_EQ(inside.materials[1].image, 0);
}

TEST(BaseColour, OfGltfHasAlphaWrapAndTransform) {
  const TempFolder folder;
  const BaseColours colours = colours_of(
      folder,
      "{\"alphaMode\": \"MASK\", \"alphaCutoff\": 0.25, \"pbrMetallicRoughness\": "
      "{\"baseColorTexture\": {\"index\": 0, \"extensions\": {\"KHR_texture_transform\": "
      "{\"offset\": [0.5, 0.25], \"rotation\": 1.5707963267948966, \"scale\": [2, 3]}}}}}, "
      "{\"alphaMode\": \"BLEND\"}, {}",
      ", \"textures\": [{\"source\": 0, \"sampler\": 0}], \"samplers\": [{\"wrapS\": 33071, "
      "\"wrapT\": 33648}], \"images\": [{\"uri\": \"data:;base64,YWJj\"}]",
      3);
  const BaseColour& masked = colours.materials[0];
  EXPECT_EQ(masked.alpha, AlphaMode::kMask);
  EXPECT_EQ(masked.cutoff, 0.25f);
  EXPECT_EQ(masked.wrap, (std::array{Wrap::kClamp, Wrap::kMirror}));
  // scale, then turn by [c s; -s c], then shift, as the extension states it
  const float expected[6] = {0, 3, 0.5f, -2, 0, 0.25f};
  for (size_t k = 0; k < 6; ++k) EXPECT_NEAR(masked.transform[k], expected[k], 1e-6) << k;
  EXPECT_EQ(colours.materials[1].alpha, AlphaMode::kBlend);
  EXPECT_EQ(colours.materials[2].alpha, AlphaMode::kOpaque);
  EXPECT_EQ(colours.materials[2].image, -1);
}

TEST(BaseColour, WhatIsMissingIsANoteThatNamesIt) {
  const TempFolder folder;
  const auto note = [&](const std::string& material, const std::string& image) {
    const BaseColours colours = colours_of(folder, material,
                                           ", \"textures\": [{\"source\": 0}], \"images\": [" +
                                               image + "], \"bufferViews\": [{\"buffer\": 7}]");
    EXPECT_EQ(colours.materials[0].image, -1);
    return colours.notes.empty() ? "" : colours.notes[0];
  };
  expect_says(note(textured(), "{\"uri\": \"none.png\"}"), "none.png");
  expect_says(note(textured(), "{\"uri\": \"../up.png\"}"), "leaves the asset's folder");
  expect_says(note(textured(), "{\"uri\": \"data:;base64,?\"}"), "base64");
  expect_says(note(textured(), "{\"bufferView\": 0}"), "has no bytes");
  expect_says(note(textured(), "{\"bufferView\": 9, \"name\": \"skin\"}"), "has no bytes");
  expect_says(note(textured(", \"texCoord\": 1"), "{\"uri\": \"data:;base64,YWJj\"}"),
              "other than the first coordinates");
}

TEST(BaseColour, WrongTypesAreAbsent) {
  const TempFolder folder;
  for (const char* wrong : {"[]", "7", "\"a\"", "{\"pbrMetallicRoughness\": 3}",
                            "{\"pbrMetallicRoughness\": {\"baseColorTexture\": [0]}}",
                            "{\"pbrMetallicRoughness\": {\"baseColorTexture\": {\"index\": -1}}}",
                            "{\"pbrMetallicRoughness\": {\"baseColorTexture\": {\"index\": 0}}, "
                            "\"alphaMode\": 3, \"alphaCutoff\": \"a\"}"}) {
    const BaseColours colours = colours_of(folder, wrong, ", \"textures\": {\"source\": 0}");
    EXPECT_EQ(colours.materials[0].image, -1) << wrong;
    EXPECT_EQ(colours.materials[0].cutoff, 0.5f) << wrong;
  }
  EXPECT_EQ(colours_of(folder, textured(), ", \"textures\": [{\"source\": \"x\"}]").images.size(),
            0u);
  // materials that the file does not have
  EXPECT_EQ(colours_of(folder, "", "", 3).materials.size(), 3u);
}

TEST(BaseColour, OfOtherFormatsIsTheFileBesideTheAsset) {
  const TempFolder folder;
  Asset asset;
  asset.format = "obj";
  asset.path = folder.path("a.obj");
  asset.materials.resize(4);
  asset.materials[0].texture = asset.materials[1].texture = folder.write("a.png", "bytes");
  asset.materials[1].base_colour[3] = 0.5f;
  asset.materials[2].texture = folder.path("gone.png");
  const BaseColours colours = base_colours(asset);
  ASSERT_EQ(colours.images.size(), 1u);
  EXPECT_EQ(colours.images[0].bytes, (Bytes{'b', 'y', 't', 'e', 's'}));
  EXPECT_EQ(colours.materials[1].image, 0);
  EXPECT_EQ(colours.materials[1].alpha, AlphaMode::kBlend);
  EXPECT_EQ(colours.materials[2].image, -1);
  ASSERT_EQ(colours.notes.size(), 1u);
  expect_says(colours.notes[0], "gone.png");
}

}  // namespace
}  // namespace elastogen::test
