// SPDX-License-Identifier: Apache-2.0
#include "cli/options.hpp"
#include "cli/scene_options.hpp"
#include "io/scene_file.hpp"
#include "tests/cli/typed_words.hpp"

namespace elastogen {
namespace {

using test::animate_options, test::refusal, test::simulate_options;
using test::error_of, test::expect_says, test::TempFolder;

/// The scene that a scene file resolves to, as text.
std::string resolved_text(const std::string& path) {
  return scene_json(resolved_scene(animate_options({"--scene", path, "--print-resolved"})));
}

TEST(YieldOptions, WhatYieldsIsSteppedByElementsOrParticles) {
  const auto with = [](std::vector<std::string> words) {
    words.insert(words.begin(), {"a.obj", "-o", "a.glb"});
    return animate_options(words);
  };
  const AnimateOptions metal = with({"--material", "steel", "--yield", "300 MPa"});
  EXPECT_EQ(std::get<MetalYield>(metal.yield).stress, 3e8);
  EXPECT_EQ(metal.material.name, "custom");
  EXPECT_TRUE(metal.fem);
  EXPECT_EQ(method_of(metal), Method::kFem);
  const AnimateOptions region = with({"--region", "y<5%: clay"});
  EXPECT_TRUE(region.fem);
  const AnimateOptions sand = with({"--material", "sand"});
  EXPECT_FALSE(sand.fem);
  EXPECT_EQ(method_of(sand), Method::kMpm);
  EXPECT_TRUE(with({"--material", "sand", "--method", "fem"}).fem);
  EXPECT_EQ(method_of(with({"--material", "steel", "--method", "mpm"})), Method::kMpm);
  const AnimateOptions elastic = with({"--material", "wood"});
  EXPECT_FALSE(elastic.fem);
  EXPECT_EQ(method_of(elastic), Method::kAuto);
}

TEST(YieldOptions, WhatDoesNotYieldHasNoMethodAndNoYieldStress) {
  expect_says(refusal({"a.obj", "-o", "a.glb", "--method", "fem"}), "--method fem");
  expect_says(refusal({"a.obj", "-o", "a.glb", "--yield", "1 MPa"}), "'rubber' is elastic");
  expect_says(refusal({"a.obj", "-o", "a.glb", "--material", "sand", "--hardening", "1"}), "sand");
  expect_says(refusal({"a.obj", "-o", "a.glb", "--material", "clay", "--method", "sph"}), "mpm");
  expect_says(error_of(
                  [] {
                    simulate_options({"a.obj", "-o", "a.glb", "--static", "--pin", "y<5%",
                                      "--material", "sand"});
                  },
                  ErrorKind::kUsage),
              "--static");
  for (const char* material : {"steel", "packed-snow"})
    EXPECT_TRUE(simulate_options(
                    {"a.obj", "-o", "a.glb", "--static", "--pin", "y<5%", "--material", material})
                    .fem->statics);
}

TEST(YieldOptions, AResolvedYieldIsAFixedPoint) {
  const TempFolder folder;
  for (const char* material : {"preset = 'steel'\nyield = 1e8", "preset = 'snow'\ncohesion = 4",
                               "preset = 'sand'\nfriction_angle = '30 deg'", "preset = 'lead'"}) {
    const std::string text = std::string("[asset]\nfile = 'a.obj'\n[material]\n") + material;
    const std::string first = resolved_text(folder.write("s.toml", text));
    EXPECT_EQ(resolved_text(folder.write("again.json", first)), first) << material;
  }
}

}  // namespace
}  // namespace elastogen
