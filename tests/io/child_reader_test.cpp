// SPDX-License-Identifier: Apache-2.0
#include "io/child_reader.hpp"

#include "io/asset_check.hpp"
#include "io/read_asset.hpp"
#include "io/weld.hpp"
#include "tests/io/foreign_files.hpp"
#include "tests/io/test_files.hpp"

#include <sys/wait.h>

#include <algorithm>
#include <cerrno>
#include <cmath>

namespace elastogen {
namespace {

using test::error_of;
using test::expect_says;
using test::TempFolder;

bool has_finding(const Asset& asset, const std::string& what) {
  return std::ranges::any_of(asset.findings, [&](const Finding& f) { return f.what == what; });
}

/// A closed tetrahedron with edges of those lengths along the axes [m], wound outwards.
void expect_wedge(const Asset& asset, const Vec3& edges, const std::string& what) {
  const Surface surface = pose_surface(asset);
  const double volume = edges[0] * edges[1] * edges[2] / 6;
  EXPECT_EQ(surface.triangles.rows(), 4) << what;
  for (int d = 0; d < 3; ++d)
    EXPECT_NEAR(surface.box.extent(d), edges[size_t(d)], 1e-6 * edges[size_t(d)]) << what << d;
  EXPECT_TRUE(weld(surface).closed()) << what;
  EXPECT_NEAR(weld(surface).volume / volume, 1, 1e-5) << what;
}

/// An executable shell script in place of the reader.
std::string script(const TempFolder& folder, const std::string& text) {
  const std::string path = folder.write("reader.sh", "#!/bin/sh\n" + text + '\n');
  std::filesystem::permissions(path, std::filesystem::perms::owner_all);
  return path;
}

int64_t open_files() {
  const std::filesystem::directory_iterator files("/proc/self/fd");
  return std::distance(begin(files), end(files));
}

/// It has no child, neither running nor waiting to be collected.
bool is_childless() {
  return ::waitpid(-1, nullptr, WNOHANG) == -1 && errno == ECHILD;
}

TEST(ChildReader, EveryFormatGivesItsMeshInItsAxesAndUnit) {
  const TempFolder folder;
  Asset asset = read_asset(folder.write("a.x", test::x_text()));
  EXPECT_EQ(asset.format, "x");
  EXPECT_EQ(asset.up, 2);
  EXPECT_EQ(asset.unit, 0);
  expect_wedge(asset, {1, 2, 3}, "x");

  asset = read_asset(folder.write("a.ac", test::ac_text()));
  EXPECT_EQ(asset.up, 2);
  EXPECT_EQ(asset.materials.at(size_t(asset.meshes.at(0).groups.at(0).material)).base_colour,
            (std::array<float, 4>{1, 0, 0, 1}));
  expect_wedge(asset, {1, 2, 3}, "ac");

  // z of a 3DS file is up: it becomes y
  asset = read_asset(folder.write("a.3DS", test::three_ds_bytes()));
  EXPECT_EQ(asset.format, "3ds");
  EXPECT_EQ(asset.up, 2);
  expect_wedge(asset, {1, 3, 2}, "3ds");
}

TEST(ChildReader, FbxKeepsItsAxesAndStatesUnitAndUp) {
  const TempFolder folder;
  for (int up = 0; up < 3; ++up) {
    const Asset asset = read_asset(folder.write("a.fbx", test::fbx_text(up, 2.54)));
    EXPECT_EQ(asset.up, up + 1);
    EXPECT_NEAR(asset.unit, 0.0254, 1e-9);
    EXPECT_EQ(asset.meshes.at(0).name, "wedge");
    expect_wedge(asset, {0.0254, 2 * 0.0254, 3 * 0.0254}, "fbx");
  }
}

TEST(ChildReader, DaeIsTurnedToYUpAndMetres) {
  const TempFolder folder;
  test::DaeOptions dae;
  dae.unit = "0.01";
  Asset asset = read_asset(folder.write("a.dae", test::dae_text(dae)));
  EXPECT_EQ(asset.up, 2);
  EXPECT_EQ(asset.unit, 1);
  expect_wedge(asset, {0.01, 0.02, 0.03}, "y up");
  dae.up = "Z_UP";
  asset = read_asset(folder.write("a.dae", test::dae_text(dae)));
  EXPECT_EQ(asset.up, 2);
  expect_wedge(asset, {0.01, 0.03, 0.02}, "z up");
}

TEST(ChildReader, TexturesOutsideTheFolderAreDropped) {
  const TempFolder folder;
  std::filesystem::create_directory(folder.path("in"));
  folder.write("outside.png", "png");
  folder.write("in/skin.png", "png");
  test::DaeOptions dae;
  dae.texture = "skin.png";
  Asset asset = read_in_child(folder.write("in/a.dae", test::dae_text(dae)), "dae");
  ASSERT_EQ(asset.materials.size(), 1u);
  EXPECT_TRUE(asset.materials[0].texture.ends_with("/in/skin.png"));
  EXPECT_FALSE(has_finding(asset, "missing-texture"));
  check_asset(asset);  // the box has no coordinates in it
  EXPECT_TRUE(has_finding(asset, "missing-uvs"));
  for (const char* name : {"../outside.png", "../../../../../../../etc/passwd", "/etc/passwd",
                           "file:///etc/passwd", "http://localhost/a.png"}) {
    dae.texture = name;
    asset = read_asset(folder.write("in/a.dae", test::dae_text(dae)));
    EXPECT_EQ(asset.materials.at(0).texture, "") << name;
    EXPECT_TRUE(has_finding(asset, "missing-texture")) << name;
  }
}

TEST(ChildReader, HostileXmlEndsInAMeshOrASentence) {
  const TempFolder folder;
  test::DaeOptions dae;
  // entities are not expanded, however large they would grow
  dae.doctype = "<!DOCTYPE l [<!ENTITY a0 'lol'>";
  for (int k = 1; k < 10; ++k) {
    std::string ten;
    for (int n = 0; n < 10; ++n) ten += concat("&a", k - 1, ';');
    dae.doctype += concat("<!ENTITY a", k, " '", ten, "'>");
  }
  dae.doctype += "]>";
  expect_wedge(read_asset(folder.write("a.dae", test::dae_text(dae))), {1, 2, 3}, "entities");

#ifndef __SANITIZE_ADDRESS__  // under which the reader's memory has no limit
  dae = {};
  dae.count = "4000000000";
  expect_says(error_of([&] { read_asset(folder.write("a.dae", test::dae_text(dae))); }), "a.dae: ");
#endif

  dae = {};
  for (int k = 0; k < 100'000; ++k) {
    dae.nodes_begin += "<node>";
    dae.nodes_end += "</node>";
  }
  const std::string deep = folder.write("a.dae", test::dae_text(dae));
  try {
    expect_wedge(read_asset(deep), {1, 2, 3}, "deep");
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kAsset);
    expect_says(error.what(), deep + ": the reader ");
  }
}

TEST(ChildReader, EveryTruncationIsReadOrRefused) {
  const TempFolder folder;
  const std::string whole = test::fbx_text(1, 1);
  int refused = 0;
  for (size_t k = 0; k < 100; ++k) {
    const std::string path = folder.write("a.fbx", whole.substr(0, whole.size() * (k + 1) / 101));
    try {
      read_asset(path);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kAsset);
      expect_says(error.what(), path + ": ");
      ++refused;
    }
  }
  EXPECT_GT(refused, 90);
  EXPECT_TRUE(is_childless());
}

TEST(ChildReader, RefusesWithAssimpsReasonOrABetterOne) {
  const TempFolder folder;
  std::string old = test::fbx_text(1, 1);
  old.replace(old.find("7400"), 4, "6100");
  expect_says(error_of([&] { read_asset(folder.write("a.fbx", old)); }),
              "a.fbx: FBX older than 7.1; re-save it as FBX 7.4 binary or glTF");
  expect_says(error_of([&] { read_asset(folder.write("b.dae", "<COLLADA")); }), "b.dae: ");
  expect_says(error_of([&] { read_in_child(folder.path("none.fbx"), "fbx"); }), "No such file");
}

TEST(ChildReader, OnlyTheImporterOfTheFormatIsAsked) {
  const TempFolder folder;
  expect_says(error_of([&] {
                read_in_child(folder.write("a.fbx", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"),
                              "fbx");
              }),
              "a.fbx: ");
}

TEST(ChildReader, SaysHowTheReaderEnded) {
  const TempFolder folder;
  const std::string path = folder.write("a.fbx", "bytes");
  const auto says = [&](const std::string& text, const std::string& part, double seconds = 10) {
    ChildOptions options;
    options.program = script(folder, text);
    options.seconds = seconds;
    options.max_bytes = 1 << 20;
    expect_says(error_of([&] { read_in_child(path, "fbx", "", options); }), path + ": " + part);
    EXPECT_TRUE(is_childless());
  };
  says("exec sleep 100", "reading it took more than 0.3 s", 0.3);
  says("exec >&-; exec sleep 100", "reading it took more than 0.3 s", 0.3);
  says("while :; do echo garbage; done", "it holds more than 1 MiB of geometry");
  says("echo garbage", "its answer is cut off");
  says("echo garbage that is as long as an answer", "its answer is no asset");
  says("exit 0", "its answer is cut off");
  says("exit 7", "the reader failed with exit code 7");
  says("kill -SEGV $$", "the reader crashed (signal 11)");
  says("kill -ABRT $$", "the reader crashed (signal 6)");
  says("kill -XCPU $$", "reading it took more than 10 s");
  says("kill -KILL $$", "the reader was ended from outside (signal 9)");
}

TEST(ChildReader, IsStartedCleanly) {
  // words, nothing on standard input, no file of ours open
  const TempFolder folder;
  ChildOptions options;
  options.program =
      script(folder, "echo \"$1 $2\" `cat` > '" + folder.path("said") +
                         "'; ls /proc/self/fd | wc -l >> '" + folder.path("said") + "'");
  const std::ifstream open_here(options.program);
  error_of([&] { read_in_child("a b.fbx", "fbx", "", options); });
  std::ifstream file(folder.path("said"));
  std::string words, files;
  std::getline(file, words);
  std::getline(file, files);
  EXPECT_EQ(words, "fbx a b.fbx");
  EXPECT_EQ(files, "4");  // of ls: 0, 1, 2 and the folder that it lists
}

TEST(ChildReader, AReaderThatCannotBeStartedIsNamed) {
  const TempFolder folder;
  ChildOptions options;
  options.program = folder.path("no-reader");
  expect_says(error_of([&] { read_in_child("a.fbx", "fbx", "", options); }),
              "a.fbx: " + options.program + " cannot be started: No such file");
}

TEST(ChildReader, FiftyFailuresLeaveNothingOpen) {
  const TempFolder folder;
  ChildOptions options;
  const int64_t before = open_files();
  for (int k = 0; k < 50; ++k) {
    options.program = k % 2 == 0 ? script(folder, "echo garbage") : folder.path("none");
    error_of([&] { read_in_child("a.fbx", "fbx", "", options); });
  }
  EXPECT_EQ(open_files(), before);
  EXPECT_TRUE(is_childless());
}

/// A row of the table of real files: triangles, posed size in the file's unit and assimp's axes,
/// metres a unit, volume (0: open).
struct RealFile {
  const char* name;
  int64_t triangles;
  Vec3 size;
  double unit;
  double volume;
};

TEST(ChildReader, RealFilesHaveTheirCountsAndSizes) {
  const std::string folder = test::assets_folder();
  if (folder.empty()) GTEST_SKIP();
  const RealFile files[] = {
      {"formats/blue_cube.dae", 12, {2, 2, 2}, 1, 8},
      {"formats/cubes_with_alpha.3DS", 60, {955, 517, 1.28e3}, 1, 2.25e8},
      {"formats/sphere.dae", 760, {0.02, 0.02, 0.02}, 1, 4.09e-6},
      {"formats/suzanne.fbx", 968, {2.73, 1.97, 1.7}, 1, 0},
      {"formats/tree.fbx", 256, {230, 507, 138}, 0.01, 0},
      {"formats/unicode_7400.fbx", 12, {200, 200, 200}, 0.01, 8e6},
      {"generators/tripo_carrot.fbx", 49998, {88.2, 200, 77.6}, 0.01, 0},
  };
  // triangles, unit, box and volume of each
  for (const RealFile& f : files) {
    const Asset asset = read_asset(folder + f.name);
    const Surface surface = pose_surface(asset);
    const WeldedMesh mesh = weld(surface);
    EXPECT_EQ(surface.triangles.rows(), f.triangles) << f.name;
    EXPECT_NEAR(surface.scale, f.unit, 1e-6 * f.unit) << f.name;
    for (int d = 0; d < 3; ++d)
      EXPECT_NEAR(surface.box.extent(d) / (f.unit * f.size[size_t(d)]), 1, 0.01) << f.name << d;
    EXPECT_EQ(mesh.closed(), f.volume > 0) << f.name;
    if (f.volume > 0) {
      EXPECT_NEAR(mesh.volume / (f.volume * std::pow(f.unit, 3)), 1, 0.01) << f.name;
    }
  }
  // findings and refusals
  EXPECT_TRUE(has_finding(read_asset(folder + "generators/tripo_carrot.fbx"), "skins"));
  expect_says(error_of([&] { read_asset(folder + "formats/unicode_6100.fbx"); }),
              "FBX older than 7.1; re-save it as FBX 7.4 binary or glTF");
}

TEST(ChildReader, RealVolumesAreRead) {
  const std::string folder = test::assets_folder();
  if (folder.empty()) GTEST_SKIP();
  const Asset asset = read_asset(folder + "vdb/spot_sdf.vdb");
  EXPECT_EQ(asset.format, "vdb");
  EXPECT_EQ(asset.nodes.at(0).name, "surface");
  const WeldedMesh mesh = weld(pose_surface(asset));
  EXPECT_TRUE(mesh.closed());
  EXPECT_NEAR(mesh.volume / 0.7183, 1, 0.01);
}

TEST(ChildReader, ARealFileCutAnywhereIsReadOrRefused) {
  const std::string folder = test::assets_folder();
  if (folder.empty()) GTEST_SKIP();
  const TempFolder here;
  std::ifstream file(folder + "formats/suzanne.fbx", std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(file), {}};
  for (size_t k = 0; k < 100; ++k) {
    const std::string path = here.write("a.fbx", whole.substr(0, whole.size() * (k + 1) / 101));
    expect_says(error_of([&] { read_asset(path); }), path + ": ");
  }
}

}  // namespace
}  // namespace elastogen
