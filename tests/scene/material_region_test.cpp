// SPDX-License-Identifier: Apache-2.0
#include "scene/material_region.hpp"

#include "core/error.hpp"
#include "scene/asset_part.hpp"
#include "voxelize/voxelize.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace elastogen {
namespace {

/// A box of this mesh's own, 1 x 1 x 1 from (x, 0, 0).
Mesh cube(double x, int material) {
  Mesh mesh;
  for (int c = 0; c < 8; ++c) {
    mesh.position.push_back({x + (c & 1), double(c >> 1 & 1), double(c >> 2)});
    mesh.position_of.push_back(c);
  }
  mesh.groups = {{material, {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                             2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5}}};
  return mesh;
}

/// Two cubes that touch at x = 0, the right one below a node of its own.
Asset two_cubes() {
  Asset asset;
  asset.path = "cubes.glb";
  asset.meshes = {cube(-1, 0), cube(0, 1)};
  asset.materials.resize(2);
  asset.materials[0].name = "wood: dark";
  asset.materials[1].name = "cloth";
  asset.nodes = {
      {"left", -1, kIdentity4, 0}, {"group", -1, kIdentity4, -1}, {"right", 1, kIdentity4, 1}};
  return asset;
}

struct Result {
  Scene scene;
  std::vector<std::string> warnings;
  int64_t count(int material) const {
    return std::count(scene.material.data(), scene.material.data() + scene.material.rows(),
                      material);
  }
};

Result applied(const std::vector<std::string>& texts) {
  RunDescription run;
  for (const std::string& text : texts) run.regions.push_back(parse_region(text));
  const Asset asset = two_cubes();
  const Body body = make_body(asset);
  Result r;
  r.scene.grid = voxelize(body.surface, {.h = 0.25, .align = {0.0, 0.0, 0.0}}).grid;
  r.scene.material = Array<int32_t>(r.scene.grid.voxel_count());
  r.scene.pinned = Array<uint8_t>(r.scene.grid.node_count());
  r.scene.materials = {{"base", Law::kNeoHookean, 1e6, 0.3, 100}};
  std::vector<Yield> yields(r.scene.materials.size());
  const std::vector<AssetPart> parts = asset_parts(run, asset, body, r.scene.grid);
  apply_regions(run.regions, parts, body.surface.box, r.scene, yields, r.warnings);
  EXPECT_EQ(yields.size(), r.scene.materials.size());
  return r;
}

TEST(MaterialRegion, ReadsSelectionsNamesAndChangesOfAPreset) {
  const MaterialRegion place = parse_region(" y<30% : jelly, young = 30 kPa,law=stvk ");
  EXPECT_EQ(place.selection.kind, Selection::Kind::kHalfSpace);
  EXPECT_EQ(place.material.young, 3e4);
  EXPECT_EQ(place.material.law, Law::kStvk);
  EXPECT_EQ(place.material.density, material_preset("jelly").material.density);
  const MaterialRegion node = parse_region("node:a:b *: foam,poisson=0.2,density=0.5 g/cm3");
  EXPECT_EQ(node.selection.kind, Selection::Kind::kNode);
  EXPECT_EQ(node.selection.name, "a:b *");
  EXPECT_EQ(node.material.poisson, 0.2);
  EXPECT_EQ(node.material.density, 500);
  EXPECT_EQ(parse_region("material:skin:rubber").selection.kind, Selection::Kind::kMaterial);
}

TEST(MaterialRegion, ReadsWhenItsMaterialYields) {
  const MaterialRegion metal = parse_region("all: steel,yield=300 MPa,hardening=2e9,young=1e11");
  EXPECT_EQ(std::get<MetalYield>(metal.yield).stress, 3e8);
  EXPECT_EQ(std::get<MetalYield>(metal.yield).hardening, 2e9);
  EXPECT_EQ(metal.material.young, 1e11);
  const MaterialRegion sand = parse_region("all: sand,friction-angle=30 deg,cohesion=0.01");
  EXPECT_NEAR(std::get<SandYield>(sand.yield).friction, 0.5235987755982988, 1e-15);
  EXPECT_EQ(std::get<SandYield>(sand.yield).cohesion, 0.01);
  // M = 6 sin/(3 - sin) = 1.2 at 30 degrees
  const MaterialRegion snow =
      parse_region("all: snow,friction-angle=30 deg,cohesion=2,hardening=3,yield=4 kPa");
  EXPECT_NEAR(std::get<SnowYield>(snow.yield).slope, 1.2, 1e-14);
  EXPECT_EQ(std::get<SnowYield>(snow.yield).cohesion, 2);
  EXPECT_EQ(std::get<SnowYield>(snow.yield).hardening, 3);
  EXPECT_EQ(std::get<SnowYield>(snow.yield).pressure, 4e3);
  EXPECT_EQ(parse_region("all: jelly").yield.index(), 0);
}

TEST(MaterialRegion, WhatCannotBeReadIsRefusedWithItsText) {
  const std::pair<const char*, const char*> rows[] = {{"y<30% jelly", "colon"},
                                                      {"y<: jelly", "selection"},
                                                      {"all: unobtainium", "rubber"},
                                                      {"all: jelly,young", "KEY=VALUE"},
                                                      {"all: jelly,colour=1", "colour"},
                                                      {"all: jelly,young=5kg", "kg"},
                                                      {"all: jelly,poisson=0.5", "0.5"},
                                                      {"all: jelly,law=wood", "hencky"},
                                                      {"all: jelly,yield=1 kPa", "elastic"},
                                                      {"all: sand,hardening=1", "sand"},
                                                      {"all: steel,yield=0", "yield stress"},
                                                      {"node: : jelly", "nothing follows 'node:'"}};
  for (const auto& [text, word] : rows) {
    try {
      parse_region(text);
      ADD_FAILURE() << text << " is taken";
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find(text), std::string::npos) << error.what();
    }
  }
}

TEST(MaterialRegion, HalvesOfABoxHaveTheirCounts) {
  // 8 x 4 x 4 voxels
  for (const char* region :
       {"x>50%: foam", "node:right: foam", "node:gro*: foam", "material:cloth: foam"}) {
    const Result r = applied({region});
    EXPECT_EQ(r.count(0), 64) << region;
    EXPECT_EQ(r.count(1), 64) << region;
    EXPECT_EQ(r.scene.materials[1].name, "foam");
    for (int64_t v = 0; v < 128; ++v)
      EXPECT_EQ(r.scene.material(v), r.scene.grid.rest(r.scene.grid.corners(v, 0), 0) > -0.1);
    EXPECT_TRUE(r.warnings.empty());
  }
  EXPECT_EQ(applied({"material:wood: dark: foam"}).count(1), 64);
}

TEST(MaterialRegion, LaterRegionsWinAndMaterialsWithoutVoxelsGo) {
  const Result r = applied({"x>50%: foam", "y>50%: jelly", "x>50%: wood"});
  ASSERT_EQ(r.scene.materials.size(), 3u);
  EXPECT_EQ(r.scene.materials[0].name, "base");
  EXPECT_EQ(r.scene.materials[1].name, "jelly");
  EXPECT_EQ(r.scene.materials[2].name, "wood");
  EXPECT_EQ(r.count(0), 32);
  EXPECT_EQ(r.count(1), 32);
  EXPECT_EQ(r.count(2), 64);
}

TEST(MaterialRegion, MassIsTheSumOfDensityTimesVolume) {
  Result r = applied({"node:right: foam"});
  finish_scene(r.scene);
  double mass = 0;
  for (int64_t n = 0; n < r.scene.mass.rows(); ++n) mass += r.scene.mass(n);
  EXPECT_NEAR(mass, 100 * 1 + 60 * 1, 1e-9);
}

TEST(MaterialRegion, ARegionWithoutVoxelsIsAWarningByName) {
  const Result r = applied({"x>3: foam"});
  ASSERT_EQ(r.warnings.size(), 1u);
  EXPECT_NE(r.warnings[0].find("x>3: foam"), std::string::npos);
  EXPECT_EQ(r.scene.materials.size(), 1u);
}

TEST(MaterialRegion, UnknownNamesAreRefusedWithTheKnownOnes) {
  const auto message = [](const char* region) -> std::string {
    try {
      applied({region});
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kUsage);
      return error.what();
    }
    return "";
  };
  const std::string node = message("node:top: foam"), material = message("material:x*: foam");
  EXPECT_NE(node.find("'group', 'left', 'right'"), std::string::npos) << node;
  EXPECT_NE(material.find("'cloth', 'wood: dark'"), std::string::npos) << material;
}

}  // namespace
}  // namespace elastogen
