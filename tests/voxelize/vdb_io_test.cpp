// SPDX-License-Identifier: Apache-2.0
#include "voxelize/vdb_io.hpp"

#include "io/weld.hpp"
#include "tests/io/test_files.hpp"
#include "tests/voxelize/shapes.hpp"

#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>
#include <openvdb/points/PointAttribute.h>
#include <openvdb/points/PointConversion.h>
#include <openvdb/tools/LevelSetSphere.h>
#include <openvdb/tools/LevelSetUtil.h>

#include <algorithm>
#include <fstream>
#include <numbers>

namespace elastogen {
namespace {

using test::error_of;
using test::expect_says;
using test::TempFolder;

/// Writes grids to a file of the folder and returns its path.
std::string written(const TempFolder& folder, const openvdb::GridCPtrVec& grids) {
  openvdb::io::File file(folder.path("a.vdb"));
  file.write(grids);
  file.close();
  return folder.path("a.vdb");
}

WeldedMesh welded(const Asset& asset) {
  return weld(pose_surface(asset));
}

/// Fill 1 or, every other voxel of one layer, 1/2 or 1/4, on n x 2 x 1 voxels.
VoxelGrid layer(int n) {
  VoxelGrid grid;
  grid.h = 0.25;
  grid.origin = {1, -2, 3};
  grid.voxel_coord = Array<int32_t>(2 * n, 3);
  grid.fill = Array<double>(2 * n);
  grid.corners = Array<int32_t>(2 * n, 8);
  grid.piece = Array<int32_t>(2);
  grid.piece(1) = 1;
  for (int v = 0; v < 2 * n; ++v) {
    grid.voxel_coord(v, 0) = v / 2 - 3;
    grid.voxel_coord(v, 1) = v % 2;
    grid.fill(v) = v % 3 == 0 ? 1 : v % 3 == 1 ? 0.5 : 0.25;
    grid.corners(v, 0) = v % 2;
  }
  return grid;
}

TEST(VdbIo, WrittenFillIsTheVolume) {
  openvdb::initialize();
  const TempFolder folder;
  const VoxelGrid grid = layer(6);
  write_vdb(folder.path("out.vdb"), grid);
  openvdb::io::File file(folder.path("out.vdb"));
  file.open(false);
  const auto fill = openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid("fill"));
  const auto piece = openvdb::gridPtrCast<openvdb::Int32Grid>(file.readGrid("piece"));
  double sum = 0;
  for (auto at = fill->cbeginValueOn(); at; ++at) sum += double(*at);
  // four voxels of each fill
  EXPECT_NEAR(sum * 0.25 * 0.25 * 0.25, 4 * 1.75 / 64, 1e-12);
  EXPECT_EQ(fill->activeVoxelCount(), 12u);
  EXPECT_EQ(fill->background(), 0);
  EXPECT_EQ(fill->getGridClass(), openvdb::GRID_FOG_VOLUME);
  EXPECT_EQ(fill->transform().indexToWorld(openvdb::Vec3d(-3, 1, 0)),
            openvdb::Vec3d(1 - 2.5 * 0.25, -2 + 1.5 * 0.25, 3 + 0.125));
  EXPECT_EQ(piece->tree().getValue({0, 0, 0}), 0);
  EXPECT_EQ(piece->tree().getValue({0, 1, 0}), 1);
}

TEST(VdbIo, WrittenBodyReadsBackWithItsVolume) {
  const TempFolder folder;
  VoxelizeOptions options;
  options.voxels = 40;
  const VoxelGrid grid = voxelize(test::sphere(0.5, {0, 0, 0}, 5).surface(), options).grid;
  write_vdb(folder.path("out.vdb"), grid);
  const WeldedMesh mesh = welded(read_vdb(folder.path("out.vdb")));
  EXPECT_TRUE(mesh.closed());
  EXPECT_NEAR(mesh.volume / grid.volume, 1, 0.02);
}

TEST(VdbIo, AFileThatCannotBeWrittenIsAnErrorOfResources) {
  expect_says(error_of([] { write_vdb("/none/out.vdb", layer(1)); }, ErrorKind::kResources),
              "/none/out.vdb");
}

TEST(VdbIo, LevelSetAndFogAreClosedAndOutwards) {
  openvdb::initialize();
  const TempFolder folder;
  const double ball = 4. / 3 * std::numbers::pi;
  auto level =
      openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(1, openvdb::Vec3f(5, 6, 7), 0.05f);
  level->setName("level");
  Asset asset = read_vdb(written(folder, {level}));
  EXPECT_EQ(asset.format, "vdb");
  EXPECT_EQ(asset.up, 0);
  EXPECT_EQ(asset.unit, 0);
  EXPECT_EQ(asset.nodes.at(0).name, "level");
  EXPECT_TRUE(asset.findings.empty());
  EXPECT_TRUE(welded(asset).closed());
  EXPECT_NEAR(welded(asset).volume / ball, 1, 0.01);
  const Box box = pose_surface(asset).box;
  EXPECT_NEAR(box.lower[0], 4, 0.01);
  EXPECT_NEAR(box.upper[2], 8, 0.01);

  // a density of 3 within, its class unknown
  auto fog = openvdb::FloatGrid::create();
  fog->setName("density");
  fog->setTransform(level->transformPtr());
  for (auto at = level->cbeginValueAll(); at; ++at)
    if (*at < 0) fog->fill(at.getBoundingBox(), 3);
  asset = read_vdb(written(folder, {fog, level}));
  EXPECT_TRUE(welded(asset).closed());
  EXPECT_NEAR(welded(asset).volume / ball, 1, 0.01);
  ASSERT_EQ(asset.findings.size(), 1u);
  expect_says(asset.findings[0].text, "\"level\"");

  // the ramp that OpenVDB makes of a level set
  const auto ramp = level->deepCopy();
  openvdb::tools::sdfToFogVolume(*ramp);
  asset = read_vdb(written(folder, {ramp}));
  EXPECT_TRUE(welded(asset).closed());
  EXPECT_NEAR(welded(asset).volume / ball, 1, 0.01);

  // signed values without a class are a level set
  level->setGridClass(openvdb::GRID_UNKNOWN);
  EXPECT_NEAR(welded(read_vdb(written(folder, {level}))).volume / ball, 1, 0.01);
}

TEST(VdbIo, RefusesWithTheGridNamed) {
  openvdb::initialize();
  const TempFolder folder;
  const auto says = [&](const openvdb::GridBase::Ptr& grid, const std::string& part) {
    grid->setName("thing");
    const std::string message = error_of([&] { read_vdb(written(folder, {grid})); });
    expect_says(message, folder.path("a.vdb") + ": ");
    expect_says(message, "\"thing\"");
    expect_says(message, part);
  };
  const auto filled = [](int edge, float value) {
    auto grid = openvdb::FloatGrid::create();
    grid->sparseFill({openvdb::Coord(0), openvdb::Coord(edge - 1)}, value);
    return grid;
  };
  says(openvdb::FloatGrid::create(), "no active voxel");
  says(openvdb::Int32Grid::create(), "there is no float grid and no points in it, only");
  says(filled(4, 0), "largest value is 0");
  says(filled(4, std::numeric_limits<float>::infinity()), "largest value is inf");
  says(filled(2048, 1), "8589934592 active voxels");
  const auto flat = openvdb::FloatGrid::create(1);
  flat->fill({openvdb::Coord(0), openvdb::Coord(3)}, 1);
  says(flat, "no surface lies in it");
}

TEST(VdbIo, DamagedFilesAreRefused) {
  const TempFolder folder;
  write_vdb(folder.path("out.vdb"), layer(6));
  std::ifstream file(folder.path("out.vdb"), std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  for (size_t n = 0; n + 1 < bytes.size(); n += 1 + bytes.size() / 97) {
    const std::string path = folder.write("b.vdb", bytes.substr(0, n));
    expect_says(error_of([&] { read_vdb(path); }), path + ": ");
  }
}

openvdb::FloatGrid::Ptr named_ball(const char* name, float radius) {
  const auto grid = openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(
      radius, openvdb::Vec3f(0), 0.05f * radius);
  grid->setName(name);
  return grid;
}

TEST(VdbIo, TakesTheFirstGridThatHasSomethingOrTheOneThatIsNamed) {
  openvdb::initialize();
  const TempFolder folder;
  const auto empty = openvdb::FloatGrid::create();
  empty->setName("a");
  const auto whole = openvdb::Int32Grid::create(1);
  whole->setName("aa");
  const std::string path = written(folder, {named_ball("c", 2), empty, whole, named_ball("b", 1)});
  const double ball = 4 * std::numbers::pi / 3;
  EXPECT_NEAR(welded(read_vdb(path)).volume / ball, 1, 0.02);  // b: a has nothing
  EXPECT_NEAR(welded(read_vdb(path, "c")).volume / (8 * ball), 1, 0.02);
  EXPECT_TRUE(read_vdb(path, "c").findings.empty());  // it was asked for
  const Asset asset = read_vdb(path);
  ASSERT_EQ(asset.findings.size(), 1u);
  EXPECT_EQ(asset.findings[0].count, 3);
  expect_says(asset.findings[0].text, "\"aa\" (int32)");
  const std::string message = error_of([&] { read_vdb(path, "density"); });
  expect_says(message, "there is no grid \"density\" in it, only \"a\"");
  expect_says(message, "\"c\" (float)");
  expect_says(error_of([&] { read_vdb(path, "a"); }), "no active voxel");
  expect_says(error_of([&] { read_vdb(path, "aa"); }), "the grid \"aa\" is not read");
}

TEST(VdbIo, PointDataGridsAreClouds) {
  openvdb::initialize();
  const TempFolder folder;
  // points with a colour and a further attribute
  std::vector<openvdb::Vec3R> places;
  for (int k = 0; k < 200; ++k) places.emplace_back(0.1 * k, 5 - 0.01 * k * k, 2 + k % 7);
  const auto transform = openvdb::math::Transform::createLinearTransform(0.5);
  const auto grid =
      openvdb::points::createPointDataGrid<openvdb::points::NullCodec,
                                           openvdb::points::PointDataGrid>(places, *transform);
  grid->setName("points");
  openvdb::points::appendAttribute<openvdb::Vec3f>(grid->tree(), "Cd",
                                                   openvdb::Vec3f(0.25f, 0.5f, 1));
  openvdb::points::appendAttribute<int>(grid->tree(), "id", 7);
  // read as a cloud, sorted to compare
  const Asset asset = read_vdb(written(folder, {grid}));
  ASSERT_TRUE(asset.points);
  ASSERT_EQ(asset.points->position.size(), places.size());
  std::vector<Vec3> expected, found = asset.points->position;
  for (const openvdb::Vec3R& p : places) expected.push_back({p[0], p[1], p[2]});
  std::ranges::sort(expected);
  std::ranges::sort(found);
  for (size_t i = 0; i < found.size(); ++i)
    for (size_t d = 0; d < 3; ++d) EXPECT_NEAR(found[i][d], expected[i][d], 1e-6);
  EXPECT_EQ(asset.points->colour.at(9), (std::array<float, 4>{0.25f, 0.5f, 1, 1}));
  EXPECT_TRUE(asset.points->normal.empty());
  // the attribute is left out
  ASSERT_EQ(asset.findings.size(), 1u);
  EXPECT_EQ(asset.findings[0].what, "lost-columns");
  expect_says(asset.findings[0].text, "id");
}

TEST(VdbIo, RealFilesHaveTheirVolume) {
  const std::string folder = test::assets_folder();
  if (folder.empty()) GTEST_SKIP();
  for (const char* name : {"vdb/spot_sdf.vdb", "vdb/spot_fog.vdb"}) {
    const Asset asset = read_vdb(folder + name);
    EXPECT_TRUE(welded(asset).closed()) << name;
    EXPECT_NEAR(welded(asset).volume / 0.7183, 1, 0.01) << name;
  }
}

}  // namespace
}  // namespace elastogen
