// SPDX-License-Identifier: Apache-2.0
#include "io/read_asset.hpp"

#include "tests/io/test_files.hpp"

namespace elastogen {
namespace {

using test::error_of;
using test::expect_says;
using test::TempFolder;

constexpr const char* kObj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
constexpr const char* kPly =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
    "property float z\nelement face 1\nproperty list uchar int vertex_index\nend_header\n"
    "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
constexpr const char* kStl =
    "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
    "endfacet\nendsolid\n";

constexpr const char* kOff = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
constexpr const char* kPcd =
    "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 2\nDATA ascii\n0 0 0\n1 1 1\n";

TEST(ReadAsset, TakesTheFormatFromTheContentThenFromTheName) {
  using namespace std::string_literals;
  const TempFolder folder;
  EXPECT_EQ(read_asset(folder.write("a.obj", kObj)).format, "obj");
  EXPECT_EQ(read_asset(folder.write("A.OBJ", kObj)).format, "obj");
  EXPECT_EQ(read_asset(folder.write("a.ply", kPly)).format, "ply");
  EXPECT_EQ(read_asset(folder.write("b.obj", kPly)).format, "ply");
  EXPECT_EQ(read_asset(folder.write("noname", kPly)).format, "ply");
  EXPECT_EQ(read_asset(folder.write("a.STL", kStl)).format, "stl");
  EXPECT_EQ(read_asset(folder.write("a.xyz", kStl)).format, "stl");
  EXPECT_EQ(read_asset(folder.write("b.xyz", kPly)).format, "ply");
  for (const char* name : {"a.off", "noname2"})
    EXPECT_EQ(read_asset(folder.write(name, kOff)).format, "off");
  EXPECT_EQ(read_asset(folder.write("b.off", "# made by a test\n" + std::string(kOff))).format,
            "off");
  for (const char* name : {"c.xyz", "c.asc", "c.PTS"})
    EXPECT_EQ(read_asset(folder.write(name, "0 0 0\n1 1 1\n")).format, "xyz");
  EXPECT_EQ(read_asset(folder.write("a.pcd", kPcd)).format, "pcd");
  EXPECT_EQ(read_asset(folder.write("noname3", "# .PCD v.7\n" + std::string(kPcd))).format, "pcd");
  const std::string one = "\0\0\x80?"s, splat = one + one + one + one + one + one + "abcdefgh";
  EXPECT_EQ(read_asset(folder.write("a.splat", splat)).format, "splat");
}

/// Latin text as UTF-16.
std::string utf16(std::string_view text, bool big, bool mark) {
  std::string bytes = mark ? big ? "\xfe\xff" : "\xff\xfe" : "";
  for (const char c : text) {
    if (big) bytes += '\0';
    bytes += c;
    if (!big) bytes += '\0';
  }
  return bytes;
}

TEST(ReadAsset, NamesUtf16AndTakesTheMarkOfUtf8) {
  const TempFolder folder;
  const std::pair<const char*, std::string> files[] = {
      {"a.obj", kObj}, {"a.ply", kPly}, {"a.stl", kStl},
      {"a.off", kOff}, {"a.pcd", kPcd}, {"a.xyz", "0 0 0\n1 1 1\n"}};
  for (const auto& [name, text] : files) {
    EXPECT_NO_THROW(read_asset(folder.write(name, "\xef\xbb\xbf" + text))) << name;
    for (const bool big : {false, true})
      for (const bool mark : {false, true}) {
        const std::string path = folder.write(name, utf16(text, big, mark));
        expect_says(error_of([&] { read_asset(path); }),
                    path + ": is UTF-16 text: save it as UTF-8");
      }
  }
  // zeros of binary files are no sign of it
  const std::string path = folder.write("b.stl", std::string(84, '\0'));
  expect_says(error_of([&] { read_asset(path); }), "nothing to simulate");
}

TEST(ReadAsset, AMaterialFileInUtf16IsAFinding) {
  const TempFolder folder;
  const std::string path = folder.write("a.obj", concat("mtllib a.mtl\nusemtl m\n", kObj));
  for (const bool big : {false, true}) {
    folder.write("a.mtl", utf16("newmtl m\nKd 1 0 0\n", big, true));
    const Asset asset = read_asset(path);
    ASSERT_EQ(asset.findings.size(), 2u);
    EXPECT_EQ(asset.findings[0].what, "unread-material-file");
    expect_says(asset.findings[0].text, "UTF-16 text: a.mtl");
  }
  folder.write("a.mtl", "\xef\xbb\xbfnewmtl m\nKd 1 0 0\n");
  EXPECT_EQ(read_asset(path).materials.at(0).base_colour[1], 0);
}

TEST(ReadAsset, ChecksWhatItRead) {
  const TempFolder folder;
  const Asset asset = read_asset(folder.write("a.obj", kObj));
  ASSERT_EQ(asset.findings.size(), 1u);
  EXPECT_EQ(asset.findings[0].what, "open");
  EXPECT_EQ(asset.findings[0].count, 3);
  const std::string path = folder.write("nan.obj", "v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n");
  expect_says(error_of([&] { read_asset(path); }), path + ": mesh \"nan\": vertex 1 ");
  expect_says(error_of([&] { read_asset(folder.write("b.obj", "v 0 0 0\n")); }),
              "nothing to simulate");
  expect_says(error_of([&] { read_asset(folder.write("c.obj", "v 1e999 0 0\n")); }), "not finite");
}

TEST(ReadAsset, SaysWhyAFileIsNotRead) {
  const TempFolder folder;
  const auto says = [](const std::string& path, const std::string& part) {
    const std::string message = error_of([&] { read_asset(path); });
    expect_says(message, path + ": ");
    expect_says(message, part);
  };
  // paths that are no file
  says(folder.path("none.obj"), "there is no such file");
  says(folder.path(""), "is a folder");
  says("/dev/null", "is not a regular file");
  says(folder.write("empty.obj", ""), "the file is empty");
  // formats by content or ending
  says(folder.write("a.usda", "#usda 1.0"),
       "usda is not read; Blender exports it as .glb; read are .obj");
  says(folder.write("fake.obj", "Kaydara FBX Binary  "), "FBX");
  says(folder.write("a.DAE", "<COLLADA>"), "malformed XML");
  says(folder.write("a.vdb", std::string(" BDV\0\0\0\0", 8)), "no float grid");
  says(folder.write("a.ksplat", "???"), "ksplat is not read; SuperSplat and splat-transform");
  says(folder.write("a.sog", "PK\x03\x04"), "sog is not read; SuperSplat and splat-transform");
  says(folder.write("a.rad", "???"), "rad is not read; SuperSplat and splat-transform");
  says(folder.write("a.e57", "ASTM-E57"), "e57 is not read; CloudCompare and PDAL");
  says(folder.write("a.laz", "???"), "laz is not read; laszip and las2las");
  says(folder.write("a.ply.gz", "\x1f\x8b"), "gzip stream is damaged");
  says(folder.write("a.spz", "NGSP"), "no SPZ header of 32 bytes");
  says(folder.write("noname", "???"), "this format is not read");
  says(folder.write("a.glb", "???"), "a.glb");
}

TEST(ReadAsset, ReadsEveryRealFileButOne) {
  const std::string folder = test::assets_folder();
  if (folder.empty()) return;
  int read = 0, refused = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    // which files are meshes or clouds
    const std::string path = entry.path().string(), ending = entry.path().extension().string();
    const std::string kind = entry.path().parent_path().filename();
    const bool is_mesh =
        ending == ".obj" || ending == ".stl" || ending == ".STL" || ending == ".off";
    const bool is_cloud = kind == "splats" || kind == "points";
    const bool is_read = is_mesh || is_cloud || kind == "formats";
    if (!entry.is_regular_file() || !is_read) continue;
    // all are read, but one old FBX
    try {
      const Asset asset = read_asset(path);
      EXPECT_EQ(asset.meshes.empty(), asset.points || asset.splats) << path;
      EXPECT_EQ(asset.meshes.empty(), is_cloud) << path;
      for (const Finding& finding : asset.findings)
        EXPECT_TRUE(!is_cloud || finding.what == "carried-columns") << path << finding.what;
      ++read;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kAsset) << path;
      EXPECT_EQ(entry.path().filename(), "unicode_6100.fbx") << error.what();
      expect_says(error.what(), path + ": ");
      ++refused;
    }
  }
  EXPECT_GE(read, 50);
  EXPECT_EQ(refused, 1);
}

}  // namespace
}  // namespace elastogen
