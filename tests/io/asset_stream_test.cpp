// SPDX-License-Identifier: Apache-2.0
#include "io/asset_stream.hpp"

#include "tests/io/test_files.hpp"

#include <cmath>
#include <cstring>
#include <random>

namespace elastogen {
namespace {

using test::error_of;
using test::expect_says;
using test::TempFolder;

constexpr size_t kCounts = 16 + 1 + 4 + 8;  ///< where the count of meshes stands

/// Every member that is sent differs from its default.
Asset sample() {
  Asset asset;
  asset.up = -3;
  asset.unit = 0.0254;
  Mesh& mesh = asset.meshes.emplace_back();
  mesh.name = "wing \xc3\xbc";
  mesh.position = {{0, 0, 0}, {1, 0, 1e-300}, {0, 1, -2}};
  mesh.position_of = {0, 1, 2, 1};
  mesh.uv = {{0, 1}, {2, 3}, {4, 5}, {6, 7}};
  mesh.normal = {{0, 0, 1}, {0, 1, 0}, {1, 0, 0}, {0, 0, -1}};
  mesh.colour = {{0, 0, 0, 1}, {1, 0, 0, 1}, {0, 1, 0, 1}, {0, 0, 1, 0.5f}};
  mesh.groups.push_back({0, {0, 1, 2}});
  mesh.groups.push_back({-1, {0, 2, 3}});
  asset.meshes.emplace_back().name = "empty";
  asset.nodes = {{"root", -1, kIdentity4, -1}, {"child", 0, kIdentity4, 0}};
  asset.nodes[1].matrix[12] = 7;
  asset.materials.push_back({"skin", {0.1f, 0.2f, 0.3f, 0.4f}, ""});
  asset.points = PointCloud{
      {{1, 2, 3}, {4, 5, 1e-300}}, {{0, 0, 1}, {1, 0, 0}}, {{1, 0, 0, 1}, {0, 1, 0, 0.5f}}, {}};
  asset.findings.push_back({"skins", 3, "said"});
  return asset;
}

TEST(AssetStream, CarriesEveryMember) {
  const Asset from = sample(), to = decode_asset(encode_asset(from), "a.fbx");
  // axes and unit
  EXPECT_EQ(to.path, "a.fbx");
  EXPECT_EQ(to.up, from.up);
  EXPECT_EQ(to.unit, from.unit);
  // meshes
  ASSERT_EQ(to.meshes.size(), 2u);
  const Mesh &a = from.meshes[0], &b = to.meshes[0];
  EXPECT_EQ(b.name, a.name);
  EXPECT_EQ(b.position, a.position);
  EXPECT_EQ(b.position_of, a.position_of);
  EXPECT_EQ(b.uv, a.uv);
  EXPECT_EQ(b.normal, a.normal);
  EXPECT_EQ(b.colour, a.colour);
  ASSERT_EQ(b.groups.size(), 2u);
  EXPECT_EQ(b.groups[1].material, -1);
  EXPECT_EQ(b.groups[1].corner, a.groups[1].corner);
  EXPECT_EQ(to.meshes[1].name, "empty");
  // points
  ASSERT_TRUE(to.points);
  EXPECT_EQ(to.points->position, from.points->position);
  EXPECT_EQ(to.points->normal, from.points->normal);
  EXPECT_EQ(to.points->colour, from.points->colour);
  EXPECT_FALSE(decode_asset(encode_asset(Asset()), "a.fbx").points);
  // nodes, materials and findings
  ASSERT_EQ(to.nodes.size(), 2u);
  EXPECT_EQ(to.nodes[1].name, "child");
  EXPECT_EQ(to.nodes[1].parent, 0);
  EXPECT_EQ(to.nodes[1].mesh, 0);
  EXPECT_EQ(to.nodes[1].matrix, from.nodes[1].matrix);
  EXPECT_EQ(to.materials.at(0).name, "skin");
  EXPECT_EQ(to.materials.at(0).base_colour, from.materials[0].base_colour);
  EXPECT_EQ(to.findings.at(0).what, "skins");
  EXPECT_EQ(to.findings.at(0).count, 3);
  EXPECT_EQ(to.findings.at(0).text, "said");
}

TEST(AssetStream, IsRefusedAtEveryTruncationAndWithATail) {
  const std::string bytes = encode_asset(sample());
  for (size_t n = 0; n < bytes.size(); ++n)
    expect_says(error_of([&] { decode_asset(bytes.substr(0, n), "a.fbx"); }), "a.fbx: its answer");
  expect_says(error_of([&] { decode_asset(bytes + '\0', "a.fbx"); }), "1 bytes too many");
  expect_says(error_of([&] { decode_asset("#!/bin/sh, some other output", "a.fbx"); }),
              "its answer is no asset");
}

TEST(AssetStream, CountsThatLieCostNothing) {
  const std::string bytes = encode_asset(sample());
  for (const uint64_t count : {uint64_t(3), uint64_t{1} << 32, uint64_t{1} << 61, ~uint64_t(0)}) {
    // of meshes, of the bytes of the name, of positions: 24 bytes each, so that 2^61 overflows
    for (const size_t at : {kCounts, kCounts + 8, kCounts + 16 + sample().meshes[0].name.size()}) {
      std::string lie = bytes;
      std::memcpy(&lie[at], &count, sizeof(count));
      if (lie == bytes) continue;
      EXPECT_FALSE(error_of([&] { decode_asset(lie, "a.fbx"); }).empty()) << count << ' ' << at;
    }
  }
}

TEST(AssetStream, AnyByteMayBeWrong) {
  const std::string bytes = encode_asset(sample());
  std::mt19937 random(1);
  for (int k = 0; k < 3000; ++k) {
    std::string bad = bytes;
    for (int flips = 1 + int(random() % 3); flips > 0; --flips)
      bad[random() % bad.size()] = char(random());
    try {
      decode_asset(bad, "a.fbx");
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kAsset);
    }
  }
}

TEST(AssetStream, UnitAndAxisAreChecked) {
  Asset asset = sample();
  asset.up = 4;
  expect_says(error_of([&] { decode_asset(encode_asset(asset), "a"); }), "the axis 4");
  for (const double unit : {-1., double(NAN), double(INFINITY)}) {
    asset = sample();
    asset.unit = unit;
    expect_says(error_of([&] { decode_asset(encode_asset(asset), "a"); }), "out of range");
  }
}

TEST(AssetStream, TexturesStayBeneathTheFolder) {
  const TempFolder folder;
  std::filesystem::create_directory(folder.path("in"));
  folder.write("outside.png", "png");
  folder.write("in/skin.png", "png");
  for (const auto& [name, found] :
       {std::pair("skin.png", true), std::pair("../outside.png", false),
        std::pair("../../../../../../etc/passwd", false), std::pair("/etc/passwd", false),
        std::pair("file:///etc/passwd", false), std::pair("none.png", false)}) {
    Asset asset = sample();
    asset.materials[0].texture = name;
    const Asset read = decode_asset(encode_asset(asset), folder.path("in/a.fbx"));
    EXPECT_EQ(!read.materials[0].texture.empty(), found) << name;
    EXPECT_EQ(read.findings.size(), found ? 1u : 2u) << name;
    if (!found) {
      EXPECT_EQ(read.findings.back().what, "missing-texture");
    }
  }
}

TEST(AssetStream, FailuresAreOneShortLine) {
  const auto says = [](ReaderFailure failure, const std::string& text) {
    return error_of([&] { decode_asset(encode_failure(failure, text), "a.fbx"); });
  };
  EXPECT_EQ(says(ReaderFailure::kRefused, "broken\nhere\x1b[2J"), "a.fbx: broken here [2J");
  EXPECT_LT(says(ReaderFailure::kRefused, std::string(100000, 'x')).size(), 400u);
  expect_says(says(ReaderFailure::kMemory, ""), "a.fbx: reading it needed more than 1 GiB");
  expect_says(says(ReaderFailure(9), "unknown"), "a.fbx: unknown");
}

}  // namespace
}  // namespace elastogen
