// SPDX-License-Identifier: Apache-2.0
#include "io/gltf_reader.hpp"
#include "io/gltf_source.hpp"
#include "tests/io/glb_files.hpp"

namespace elastogen {
namespace {

using test::Builder, test::error_of, test::expect_says, test::Json, test::triangle;

TEST(GltfUri, OpensFilesBeneathTheFolderOnly) {
  const test::TempFolder folder;
  Builder builder = triangle();
  std::filesystem::create_directories(folder.path("inner/deeper"));
  folder.write("outside.bin", builder.bin);
  folder.write("inner/deeper/b c.bin", builder.bin);
  const auto with = [&](const std::string& uri) {
    Json document = builder.document;
    document["buffers"] = {{{"byteLength", builder.bin.size()}, {"uri", uri}}};
    return folder.write("inner/a.gltf", document.dump());
  };
  const Asset asset = read_gltf(with("deeper/b%20c.bin"));
  EXPECT_EQ(asset.format, "gltf");
  EXPECT_EQ(asset.meshes[0].position[1], (Vec3{1, 0, 0}));
  std::filesystem::create_symlink(folder.path("outside.bin"), folder.path("inner/link.bin"));
  for (const std::string& uri :
       {std::string("../outside.bin"), std::string("deeper/../../outside.bin"),
        std::string("%2e%2e/outside.bin"), folder.path("outside.bin"),
        "file://" + folder.path("outside.bin"), std::string("https://example.org/a.bin"),
        std::string("link.bin"), std::string("missing.bin"), std::string("deeper"),
        std::string("")}) {
    expect_says(error_of([&] { read_gltf(with(uri)); }), "buffers[0]");
  }
}

TEST(GltfUri, DecodesDataUris) {
  const test::TempFolder folder;
  Json document = triangle().document;
  document["meshes"][0]["primitives"][0] = {{"attributes", {{"POSITION", 0}}}};
  document["bufferViews"][0]["byteLength"] = 36;
  // nine floats: 0 0 0 1 0 0 0 1 0
  const std::string text = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
  const auto with = [&](const std::string& uri, int size) {
    document["buffers"] = {{{"byteLength", size}, {"uri", uri}}};
    document["bufferViews"].erase(3);
    document["bufferViews"].push_back(document["bufferViews"][0]);
    return folder.write("data.gltf", document.dump());
  };
  const Asset asset = read_gltf(with("data:application/octet-stream;base64," + text, 36));
  EXPECT_EQ(asset.meshes[0].position, (std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
  const auto refused = [&](const std::string& uri, int size) {
    const std::string path = with(uri, size);
    return error_of([&] { read_gltf(path); });
  };
  expect_says(refused("data:;base64," + text, 37), "only 36 bytes");
  expect_says(refused("data:;base64,AA*A", 3), "base64");
  expect_says(refused("data:text/plain,abc", 3), "base64");
  expect_says(refused("data:", 3), "base64");
}

}  // namespace
}  // namespace elastogen
