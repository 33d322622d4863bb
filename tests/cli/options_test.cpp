// SPDX-License-Identifier: Apache-2.0
#include "cli/options.hpp"

#include "cli/scene_options.hpp"
#include "io/scene_file.hpp"
#include "io/scene_keys.hpp"
#include "tests/cli/typed_words.hpp"

namespace elastogen {
namespace {

using test::animate_options, test::parsed_words, test::refusal, test::simulate_options;
using test::error_of, test::expect_says, test::TempFolder;

/// Values as they were typed.
template <class Values>
std::vector<std::string> texts_of(const Values& values) {
  std::vector<std::string> texts;
  for (const auto& value : values) texts.push_back(value.text);
  return texts;
}

/// The scene that a scene file resolves to, as text.
std::string resolved(const std::string& path, std::vector<std::string> more = {}) {
  more.insert(more.begin(), {"--scene", path, "--print-resolved"});
  return scene_json(resolved_scene(animate_options(more)));
}

constexpr const char* kScene = R"~(
pins = ["y<5%"]
gravity = "0, 0, -1 g0"
[asset]
file = "bunny.obj"
h = "5 mm"
part_pieces = true
thickness = "2 mm"
up = "-z"
splat_scales = "linear"
grid = "density"
[material]
preset = "jelly"
young = "30 kPa"
[[pin]]
select = "box(0,0,0, 1,1,1)"
[[region]]
gltf_material = "ears"
preset = "foam"
density = 40
[[region]]
select = "y>80%"
[[collider]]
shape = "box"
lower = [0, "-5 cm", 0]
upper = [1, 0, 1]
friction = 0.125
name = "step"
path = [[0, 0, 0, 0], [1, 0, 0.5, 0]]
[[collider]]
shape = "plane"
centre = [0, -1, 0]
normal = [0, 1, 0]
[[hold]]
select = "x<1%"
axes = "xz"
[[traction]]
select = "x>99%"
force = [0, "-1 kN", 0]
[[traction]]
select = "z>99%"
pressure = "-2 kPa"
[[move]]
select = "y<1%"
path = [[0, 0, 0, 0], [1, 0, 0.5, 0]]
[[move]]
select = "y>99%"
turn = [[0, 0], [2, 0.5]]
turn_centre = [0, 1, 0]
turn_axis = [0, 0, 1]
[motion]
spin = "0, 90, 0 deg/s"
[floor]
axis = "y"
place = "-30 cm"
friction = 0.25
[time]
frames = 7
fps = 24
substeps = 3
scheme = "bdf2"
error = 0.002
[solver]
mode = "newton"
hourglass = "variance"
outer = 4
inner = 5
modes = 6
skip = false
threads = 1
[limits]
max_voxels = 1000000
max_memory = "1 GiB"
max_time = "2 min"
strict = true
strict_time = true
[output]
files = ["a.glb", "b.glb"]
glb_profile = "keyframe"
glb_targets = 100
glb_colliders = true
state = "s.h5"
log = "l.json"
report = "r.json"
quiet = true
)~";

TEST(Options, ASceneSetsEveryOption) {
  const TempFolder folder;
  const AnimateOptions o = simulate_options({"--scene", folder.write("s.toml", kScene)});
  // the values of kScene, in SI units
  EXPECT_EQ(o.input, folder.path("bunny.obj"));
  EXPECT_EQ(o.h, 0.005);
  ASSERT_TRUE(o.up);
  EXPECT_EQ(up_name(*o.up), "-z");
  EXPECT_EQ(o.read.splat_scales, SplatScales::kLinear);
  EXPECT_EQ(o.read.grid, "density");
  EXPECT_EQ(o.material.law, Law::kStableNeoHookean);
  EXPECT_EQ(o.material.young, 3e4);
  EXPECT_EQ(o.material.name, "custom");
  EXPECT_EQ(texts_of(o.pins), (std::vector<std::string>{"y<5%", "box(0,0,0, 1,1,1)"}));
  EXPECT_EQ(texts_of(o.regions),
            (std::vector<std::string>{"material:ears: foam,density=40", "y>80%: jelly"}));
  EXPECT_EQ(texts_of(o.colliders),
            (std::vector<std::string>{
                "box(0,-0.05,0, 1,0,1) friction 0.125 name step path 0:0,0,0; 1:0,0.5,0",
                "plane(0,-1,0, 0,1,0)"}));
  EXPECT_EQ(texts_of(o.holds), std::vector<std::string>{"x<1%: xz"});
  EXPECT_EQ(texts_of(o.tractions), (std::vector<std::string>{"x>99%: 0,-1000,0", "z>99%: -2000"}));
  EXPECT_EQ(texts_of(o.moves), (std::vector<std::string>{"y<1%: shift 0:0,0,0; 1:0,0.5,0",
                                                         "y>99%: turn(0,1,0, 0,0,1) 0:0; 2:0.5"}));
  EXPECT_DOUBLE_EQ((*o.gravity)[2], -9.80665);
  EXPECT_NEAR(o.motion.spin[1], 1.5707963267948966, 1e-15);
  ASSERT_TRUE(o.floor);
  EXPECT_EQ(o.floor->axis, 1);
  EXPECT_DOUBLE_EQ(o.floor->place.value(), -0.3);
  EXPECT_EQ(o.friction, 0.25);
  EXPECT_EQ(o.frames, 7);
  EXPECT_EQ(o.fps, 24);
  EXPECT_EQ(o.substeps, 3);
  EXPECT_EQ(o.scheme, TimeScheme::kBdf2);
  EXPECT_EQ(o.solver.time_error, 0.002);
  EXPECT_EQ(o.solver.mode, SolverMode::kNewton);
  EXPECT_EQ(o.hourglass, Hourglass::kVariance);
  EXPECT_EQ(o.solver.paper.outer * 100 + o.solver.paper.inner * 10 + o.solver.paper.modes, 456);
  EXPECT_FALSE(o.solver.skip);
  EXPECT_EQ(o.threads, 1);
  EXPECT_EQ(o.max_voxels, 1'000'000);
  EXPECT_EQ(o.max_memory, 1 << 30);
  EXPECT_EQ(o.max_time, 120);
  EXPECT_TRUE(o.strict && o.strict_time && o.quiet && o.keyframe && o.glb_colliders &&
              o.part_pieces);
  EXPECT_EQ(o.thickness, 0.002);
  EXPECT_EQ(o.glb_targets, 100);
  EXPECT_EQ(o.outputs, (std::vector<std::string>{"a.glb", "b.glb"}));
  EXPECT_EQ(o.state + o.log + o.report, "s.h5l.jsonr.json");
}

TEST(Options, WhatIsTypedWinsOverTheScene) {
  const TempFolder folder;
  const std::string scene = folder.write("s.toml", kScene);
  const AnimateOptions o = simulate_options(
      {"other.obj", "--scene", scene, "--pin", "all", "--frames", "9", "--skip", "--no-strict",
       "--floor", "off", "--up", "auto", "--gravity", "auto", "--max-time", "none", "-o", "c.glb"});
  EXPECT_EQ(o.input, "other.obj");
  EXPECT_EQ(texts_of(o.pins), std::vector<std::string>{"all"});
  EXPECT_EQ(o.outputs, std::vector<std::string>{"c.glb"});
  EXPECT_EQ(o.frames, 9);
  EXPECT_TRUE(o.solver.skip);
  EXPECT_FALSE(o.strict || o.floor || o.up || o.gravity);
  EXPECT_EQ(o.max_time, 0);
  EXPECT_EQ(o.fps, 24);  // the rest stays
  EXPECT_EQ(o.colliders.size(), 2u);
}

TEST(Options, AMaterialOrAResolutionIsReplacedWhole) {
  const TempFolder folder;
  const std::string scene = folder.write("s.toml", kScene);
  const AnimateOptions o =
      simulate_options({"--scene", scene, "--material", "wood", "--voxels", "20"});
  EXPECT_EQ(o.material.young, 1e10);
  EXPECT_EQ(o.material.name, "wood");
  EXPECT_EQ(o.voxels, 20);
  EXPECT_EQ(o.h, 0);
}

TEST(Options, TheResolvedSceneIsAFixedPoint) {
  const TempFolder folder;
  for (const std::string& text : {std::string(kScene), std::string()}) {
    const std::string first = resolved(folder.write("s.toml", text));
    EXPECT_EQ(resolved(folder.write("again.json", first)), first);
    const std::string json = scene_json(check_scene(text, folder.path("s.toml")));
    EXPECT_EQ(resolved(folder.write("s.json", json)), first);
  }
}

TEST(Options, TheResolvedSceneHasEveryKey) {
  const SceneValue scene = resolved_scene(AnimateOptions{});
  for (const SceneKey& key : scene_keys()) {
    const SceneTable* table = find_scene_table(key.table);
    if (table && table->many) continue;  // they are in pins, regions and colliders
    if (key.table == "shape") continue;  // there is none
    const std::vector<std::string> yields = {"yield", "hardening", "friction_angle", "cohesion",
                                             "keeps_volume"};
    if (std::find(yields.begin(), yields.end(), key.name) != yields.end()) continue;  // no yielding
    const SceneValue* home = table ? scene.find(key.table) : &scene;
    ASSERT_TRUE(home) << key.table;
    EXPECT_TRUE(home->find(key.name)) << key.path();
  }
}

TEST(Options, TheDefaultsAreThoseOfTheTable) {
  const SceneValue scene = resolved_scene(AnimateOptions{});
  for (const char* path : {"asset.size",        "asset.up",           "asset.voxels",
                           "asset.h",           "asset.splat_scales", "asset.grid",
                           "gravity",           "floor.axis",         "floor.place",
                           "floor.friction",    "time.frames",        "time.fps",
                           "time.substeps",     "solver.mode",        "time.error",
                           "solver.tolerance",  "solver.outer",       "solver.inner",
                           "solver.modes",      "solver.threads",     "particles.integrator",
                           "particles.dt",      "particles.substeps", "particles.per_edge",
                           "particles.jitter",  "particles.transfer", "particles.blend_time",
                           "particles.flip",    "particles.passes",   "solver.device",
                           "limits.max_voxels", "limits.max_memory",  "limits.max_time",
                           "output.camera",     "output.image_size",  "output.glb_profile",
                           "solver.energy",     "solver.method",      "solver.mesh_error"}) {
    const std::string text = path;
    const size_t dot = text.find('.');
    const std::string table = dot == std::string::npos ? "" : text.substr(0, dot);
    const std::string name = text.substr(dot + 1);
    const SceneValue* home = table.empty() ? &scene : scene.find(table);
    const SceneValue& value = *home->find(name);
    // the value as the table writes it
    const std::string shown =
        value.kind == SceneValue::Kind::kNumber ? concat(int64_t(value.number)) : value.text;
    const bool whole = value.number == double(int64_t(value.number));
    EXPECT_EQ(whole ? shown : concat(value.number), find_scene_key(table, name)->fallback) << path;
  }
}

TEST(Options, EveryWordOfTheTableIsAnOptionsValue) {
  const TempFolder folder;
  for (const SceneKey& key : scene_keys()) {
    if (!*key.option || key.words.empty()) continue;
    for (std::string word : key.words) {
      if (const size_t at = word.find("=NUMBER"); at != word.npos)
        word.replace(at, word.npos, word.starts_with("gent") ? "=12.5" : "=1");
      const std::string head = key.table.empty() ? "" : '[' + key.table + "]\n";
      const std::string scene = folder.write("s.toml", head + key.name + " = \"" + word + "\"\n");
      EXPECT_NO_THROW(resolved(scene)) << key.path() << ' ' << word;
    }
  }
}

TEST(Options, AFloorIsAPlaneOrOff) {
  const std::vector<std::string> base = {"a.obj", "-o", "a.glb", "--floor"};
  const auto floor_of = [&](const std::string& text) {
    std::vector<std::string> words = base;
    if (!text.empty()) words.push_back(text);
    return animate_options(words).floor;
  };
  EXPECT_EQ(floor_of("")->axis, -1);
  EXPECT_FALSE(floor_of("")->place);
  EXPECT_EQ(floor_of("x=auto")->axis, 0);
  EXPECT_FALSE(floor_of("x=auto")->place);
  EXPECT_EQ(floor_of("auto=-3cm")->axis, -1);
  EXPECT_DOUBLE_EQ(floor_of("auto=-3cm")->place.value(), -0.03);
  EXPECT_FALSE(floor_of("off"));
  for (const char* wrong : {"q=1", "y", "y=", "off=1", "=1"})
    expect_says(refusal({"a.obj", "-o", "a.glb", "--floor", wrong}), "PLACE");
  expect_says(refusal({"a.obj", "-o", "a.glb", "--floor", "y=1kg"}), "kg");
}

TEST(Options, RunsRepeatWhetherThatIsSaidOrNot) {
  EXPECT_NO_THROW(animate_options({"a.obj", "-o", "a.glb", "--deterministic"}));
  EXPECT_FALSE(parsed_words({"animate", "a.obj", "-o", "a.glb", "--no-deterministic"}).animate);
}

TEST(Options, NoOutputTakesThePlaceOfAnother) {
  const TempFolder folder;
  const std::string scene = folder.write("s.toml", "[time]\nframes = 3\n");
  const auto says = [&](const std::string& input, std::vector<std::string> words) {
    words.insert(words.begin(), {input, "--scene", scene});
    return refusal(words);
  };
  const std::string a = folder.path("a.obj"), ply = folder.path("a.ply");
  const auto two = "two files of one name";
  expect_says(says(a, {"-o", "x.glb", "--report", a}), two);
  expect_says(says(a, {"-o", "x.glb", "--log-json", folder.path("./a.obj")}), two);
  expect_says(says(a, {"-o", "x.glb", "--state", scene}), two);
  expect_says(says(a, {"-o", "x.glb", "-o", "./x.glb"}), two);
  expect_says(says(a, {"-o", ply, "-o", folder.path("a.PLY")}), two);
  expect_says(says(folder.path("a_00000.ply"), {"-o", ply}), two);
  // frames 1 ... 3 are written, the fourth is not
  expect_says(says(folder.path("a_00003.ply"), {"-o", ply}), "a_00003.ply: a frame of");
  expect_says(says(a, {"-o", folder.path("a.pvd"), "--log-json", folder.path("a_00001.vtu")}),
              "a frame of");
  for (const char* free : {"a_00004.ply", "a_1.ply", "a_00001.obj", "b_00001.ply"})
    EXPECT_EQ(animate_options({folder.path(free), "--scene", scene, "-o", ply}).frames, 3) << free;
  const std::string pictures = folder.path("a_%02d.png");
  for (const char* taken : {"a_00.png", "a_03.png"})
    expect_says(says(a, {"-o", pictures, "--report", folder.path(taken)}), taken);
  expect_says(says(a, {"-o", pictures, "-o", folder.path("a_02.png")}), "a frame of");
  EXPECT_EQ(animate_options({a, "--scene", scene, "-o", pictures, "-o", folder.path("a_04.png"),
                             "-o", folder.path("a.png")})
                .outputs.size(),
            3u);
  expect_says(says(a, {"-o", folder.path("a_%d_%d.png")}), "a % in the name of pictures");
  // an animation of one file may replace the asset, a sequence does not touch the name itself
  for (const char* same : {"a.glb", "a.ply"})
    EXPECT_EQ(animate_options({folder.path(same), "-o", folder.path(same)}).outputs.size(), 1u);
}

TEST(Options, PicturesHaveACameraAndASize) {
  const AnimateOptions o =
      animate_options({"a.obj", "-o", "a.png", "--camera", "turntable", "--image-size", "80x60"});
  EXPECT_EQ(o.picture.view, View::kTurntable);
  EXPECT_EQ(o.picture.width, 80);
  EXPECT_EQ(o.picture.height, 60);
  EXPECT_EQ(animate_options({"a.obj", "-o", "a.png"}).picture.view, View::kThreeQuarter);
  const auto says = [](const char* option, const char* value) {
    return refusal({"a.obj", "-o", "a.png", option, value});
  };
  expect_says(says("--camera", "bakc"), "did you mean back?");
  expect_says(says("--image-size", "0x0"), "--image-size '0x0'");
  expect_says(says("--image-size", "4096x4096"), "a picture of a sheet");
}

TEST(Options, NamesAreComparedBehindLinksOfFolders) {
  const TempFolder folder;
  std::filesystem::create_directory(folder.path("real"));
  std::filesystem::create_directory_symlink(folder.path("real"), folder.path("link"));
  expect_says(
      refusal({folder.path("real/a.obj"), "-o", "x.glb", "--state", folder.path("link/a.obj")}),
      "two files of one name");
}

TEST(Options, AStaticRunIsOneStepFromRest) {
  const auto statics = [](std::vector<std::string> words) {
    words.insert(words.begin(), {"simulate", "a.obj", "-o", "a.glb", "--static"});
    return words;
  };
  const AnimateOptions o =
      parsed_words(statics({"--pin", "x<1%", "--frames", "9"})).animate.value();
  EXPECT_TRUE(o.fem && o.fem->statics);
  EXPECT_EQ(o.frames, 1);
  EXPECT_EQ(o.fps, 1);
  EXPECT_EQ(o.substeps, 1);
  const auto says = [&](std::vector<std::string> words) {
    return error_of([&] { parsed_words(statics(words)); }, ErrorKind::kUsage);
  };
  expect_says(says({}), "nothing holds the asset");
  expect_says(says({"--pin", "all", "--floor"}), "--floor");
  expect_says(says({"--pin", "all", "--collider", "sphere(0,0,0,1)"}), "--collider");
  expect_says(says({"--pin", "all", "--spin", "1,0,0"}), "--spin");
}

TEST(Options, RefusesWhatIsMissing) {
  expect_says(refusal({"a.obj"}), "--output");
  expect_says(refusal({"-o", "a.glb"}), "INPUT");
  expect_says(refusal({"a.obj", "-o", "a.glb", "--scene", "no/such.toml"}), "no/such.toml");
  expect_says(refusal({"a.obj", "-o", "a.glb", "--up", "w"}), "--up");
  expect_says(refusal({"a.ply", "-o", "a.glb", "--splat-scales", "ln"}), "--splat-scales");
  expect_says(refusal({"a.obj", "-o", "a.glb", "--modes", "4"}), "--modes");
  const auto voxelize = [] { parsed_words({"voxelize", "a.obj", "-o", "a.glb"}); };
  expect_says(error_of(voxelize, ErrorKind::kUsage), ".vdb");
  expect_says(error_of([] { parsed_words({"inspect"}); }, ErrorKind::kUsage), "FILE");
}

}  // namespace
}  // namespace elastogen
