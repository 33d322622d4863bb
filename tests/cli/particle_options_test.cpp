// SPDX-License-Identifier: Apache-2.0
// Bodies without a file and particles: typed, from scene files, and what is refused.
#include "cli/options.hpp"
#include "cli/scene_options.hpp"
#include "io/scene_file.hpp"
#include "tests/cli/typed_words.hpp"

namespace elastogen {
namespace {

using test::animate_options, test::parsed_words, test::refusal;
using test::error_of, test::expect_says, test::TempFolder;

constexpr const char* kParticleScene = R"~(
[shape]
kind = "disk"
centre = [0, "12 cm", 0]
radius = 0.125
[material]
preset = "sand"
keeps_volume = false
[[region]]
select = "y<1%"
preset = "sand"
keeps_volume = false
[floor]
friction = "sticky"
[[collider]]
shape = "plane"
centre = [-1, 0, 0]
normal = [1, 0, 0]
friction = "sticky"
[particles]
integrator = "explicit"
dt = "500 us"
substeps = 40
passes = 5
per_edge = 3
jitter = 0.25
transfer = "apic-blend"
blend_time = "20 ms"
flip = 0.5
[output]
files = ["a.ply"]
)~";

std::string resolved_particles(const std::string& path) {
  return scene_json(resolved_scene(animate_options({"--scene", path, "--print-resolved"})));
}

TEST(ParticleOptions, ASceneSetsThemAll) {
  const TempFolder folder;
  const AnimateOptions o = animate_options({"--scene", folder.write("s.toml", kParticleScene)});
  ASSERT_TRUE(o.shape);
  EXPECT_EQ(o.shape->kind, BodyShape::Kind::kDisk);
  EXPECT_EQ(o.shape->centre, (Vec3{0, 0.12, 0}));
  EXPECT_EQ(o.shape->radius, 0.125);
  EXPECT_EQ(o.input, "");
  EXPECT_FALSE(std::get<SandYield>(o.yield).keeps_volume);
  EXPECT_FALSE(std::get<SandYield>(o.regions.at(0).yield).keeps_volume);
  EXPECT_EQ(o.friction, kSticks);
  EXPECT_EQ(o.colliders.at(0).friction, kSticks);
  const ParticleOptions& p = o.particles;
  EXPECT_EQ(p.integrator, Integrator::kExplicit);
  EXPECT_EQ(p.dt, 5e-4);
  EXPECT_EQ(p.substeps, 40);
  EXPECT_EQ(p.passes, 5);
  EXPECT_EQ(p.per_edge, 3);
  EXPECT_EQ(p.jitter, 0.25);
  EXPECT_EQ(p.transfer.kind, mpm::Transfer::kBlend);
  EXPECT_EQ(p.transfer.blend_time, 0.02);
  EXPECT_EQ(p.transfer.flip, 0.5);
}

TEST(ParticleOptions, ASceneFileMayStandWhereAnAssetDoes) {
  const TempFolder folder;
  const std::string scene = folder.write("s.toml", kParticleScene);
  const AnimateOptions o = animate_options({scene, "--jitter", "0"});
  EXPECT_EQ(o.input, "");
  EXPECT_EQ(o.particles.substeps, 40);
  EXPECT_EQ(o.particles.jitter, 0);
  EXPECT_EQ(parsed_words({"study", scene}).study.value().scene.particles.substeps, 40);
  expect_says(refusal({scene, "--scene", scene}), "two files of one name");
}

TEST(ParticleOptions, TheResolvedSceneIsAFixedPoint) {
  const TempFolder folder;
  const std::string boxes = "[shape]\nkind = 'box'\nlower = [0, 0, 0]\nupper = [1, '20 cm', 3]\n";
  for (const std::string& text : {std::string(kParticleScene), boxes}) {
    const std::string first = resolved_particles(folder.write("s.toml", text));
    EXPECT_EQ(resolved_particles(folder.write("again.json", first)), first);
  }
}

TEST(ParticleOptions, WhatIsTypedWinsOverTheScene) {
  const TempFolder folder;
  const std::string scene = folder.write("s.toml", kParticleScene);
  const AnimateOptions o =
      animate_options({"--scene", scene, "--shape", "sphere(0,1,0, 2)", "--dt", "auto",
                       "--integrator", "implicit", "--friction", "0.25", "--keeps-volume", "true"});
  EXPECT_EQ(o.shape->kind, BodyShape::Kind::kSphere);
  EXPECT_EQ(o.particles.dt, 0);
  EXPECT_EQ(o.particles.integrator, Integrator::kImplicit);
  EXPECT_EQ(o.friction, 0.25);
  EXPECT_TRUE(std::get<SandYield>(o.yield).keeps_volume);
  const AnimateOptions file = animate_options({"a.obj", "--scene", scene, "-o", "b.ply"});
  EXPECT_FALSE(file.shape);
  EXPECT_EQ(file.input, "a.obj");
  const std::string asset = folder.write("f.toml", "[asset]\nfile = 'a.obj'\n");
  EXPECT_EQ(animate_options({"--scene", asset, "--shape", "disk(0,0,0, 1)", "-o", "b.ply"}).input,
            "");
}

/// Scenes with a key missing or one too many: the message has file, line and key.
TEST(ParticleOptions, BadKeysOfScenesAreNamedWithTheirPlace) {
  const TempFolder folder;
  const auto says = [&](const std::string& text) {
    return refusal({"--scene", folder.write("s.toml", text), "-o", "a.ply"});
  };
  for (const auto& [text, place] :
       {std::pair("[shape]\nradius = 1\n", "s.toml:1: 'shape': needs kind"),
        {"[shape]\nkind = 'box'\nlower = [0, 0, 0]\n", "s.toml:1: 'shape': a box needs lower and"},
        {"[shape]\nkind = 'disk'\ncentre = [0, 0, 0]\nradius = 1\nupper = [1, 1, 1]\n",
         "s.toml:5: 'shape.upper': a disk has none"},
        {"[shape]\nkind = 'torus'\n", "s.toml:2: 'shape.kind': 'torus' is not known"},
        {"[shape]\nkind = 'sphere'\ncentre = [0, 0, 0]\nradius = 0\n",
         "s.toml:4: 'shape.radius': above 0"},
        {"[particles]\ndt = '1 kg'\n", "s.toml:2: 'particles.dt'"},
        {"[particles]\nper_edge = 1.5\n", "s.toml:2: 'particles.per_edge': a whole number"},
        {"[particles]\njitter = 2\n", "s.toml:2: 'particles.jitter': at least 0, at most 1"},
        {"[particles]\ntransfer = 'pic'\n", "s.toml:2: 'particles.transfer': 'pic' is not known"},
        {"[particles]\nintergator = 1\n", "the nearest is 'particles.integrator'"},
        {"[floor]\nfriction = 'glue'\n", "s.toml:2: 'floor.friction'"},
        {"[asset]\nfile = 'a.obj'\n[shape]\nkind = 'disk'\ncentre = [0, 0, 0]\nradius = 1\n",
         "--shape stands in place of a file"}})
    expect_says(says(text), place);
  expect_says(says("[time]\nframes = 1\n"), "needs an INPUT, a --shape");
}

TEST(ParticleOptions, BadOptionsAreNamed) {
  const auto says = [](std::vector<std::string> words) {
    words.insert(words.begin(), {"-o", "a.ply", "--material", "sand"});
    return refusal(words);
  };
  const std::string shape = "box(0,0,0, 1,1,1)";
  expect_says(says({"a.obj", "--shape", shape}), "'a.obj'");
  expect_says(says({"--shape", shape, "--size", "1 m"}), "--size");
  expect_says(says({"--shape", "box(0,0,0)"}), "--shape 'box(0,0,0)'");
  for (const auto& [option, value] : {std::pair("--dt", "0"),
                                      {"--integrator", "verlet"},
                                      {"--transfer", "pic"},
                                      {"--per-edge", "9"},
                                      {"--jitter", "-1"},
                                      {"--particle-substeps", "0"},
                                      {"--passes", "0"},
                                      {"--blend-time", "0"},
                                      {"--flip", "1.5"},
                                      {"--keeps-volume", "maybe"}})
    expect_says(says({"--shape", shape, option, value}),
                std::string_view(option) == "--keeps-volume" ? "maybe" : option);
}

TEST(ParticleOptions, AStudyOfParticlesHasExplicitSteps) {
  const auto study = [](std::vector<std::string> words) {
    words.insert(words.begin(), {"study", "--shape", "disk(0,0,0, 1)", "--material", "sand"});
    return parsed_words(words).study.value();
  };
  EXPECT_EQ(study({}).explicit_dts, std::vector<double>{1e-5});
  EXPECT_EQ(study({"--explicit-dt", "1 ms,2e-4"}).explicit_dts, (std::vector<double>{1e-3, 2e-4}));
  EXPECT_TRUE(study({"--explicit-dt", "none"}).explicit_dts.empty());
  EXPECT_FALSE(study({"--no-noise-floor"}).noise_floor);
  EXPECT_THROW(study({"--explicit-dt", "0"}), Error);
}

}  // namespace
}  // namespace elastogen
