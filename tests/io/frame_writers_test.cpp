// SPDX-License-Identifier: Apache-2.0
#include "core/time_scheme.hpp"
#include "io/animation_writer.hpp"
#include "io/safe_file.hpp"
#include "tests/io/test_files.hpp"
#include "voxelize/bricks.hpp"

#include <cmath>
#include <cstring>
#include <map>
#include <numbers>
#include <sstream>

namespace elastogen {
namespace {

using test::error_of, test::expect_says;

template <class T>
std::vector<T> values_at(const std::string& bytes, size_t offset, size_t count) {
  std::vector<T> values(count);
  EXPECT_LE(offset + count * sizeof(T), bytes.size());
  if (offset + count * sizeof(T) <= bytes.size())
    std::memcpy(values.data(), bytes.data() + offset, count * sizeof(T));
  return values;
}

const Surface kUnitScale;  // of clouds: nothing but the scale matters

/// A triangle at (1, 2, 3) with vertices one apart, shown by a node that doubles it.
Asset unit_triangle() {
  Asset asset;
  asset.path = "triangle.obj";
  Mesh& mesh = asset.meshes.emplace_back();
  mesh.position = {{1, 2, 3}, {2, 2, 3}, {1, 3, 3}};
  mesh.position_of = {0, 1, 2};
  mesh.groups.push_back({-1, {0, 1, 2}, -1});
  Matrix4 twice = kIdentity4;
  twice[0] = twice[5] = twice[10] = 2;
  asset.nodes.push_back({"node", -1, twice, 0});
  return asset;
}

Asset cloud() {
  Asset asset;
  asset.path = "cloud.ply";
  PointCloud& points = asset.points.emplace();
  points.position = {{1, 2, 3}, {1e5 + 0.1, 0, 0}};
  points.normal = {{0, 0, 1}, {0.6f, 0.8f, 0}};
  // 128 of 255 in sRGB is 0.2158605 linear
  points.colour = {{1, 0, 0.2158605f, 1}, {0, 1, 1, 0.5f}};
  return asset;
}

Asset splats(int degree) {
  Asset asset;
  asset.path = "splats.ply";
  SplatCloud& s = asset.splats.emplace();
  s.degree = degree;
  s.position = {{0.1f, -2, 3}, {4, 5, 6}};
  s.scale = {{0.5f, 0.25f, 0.125f}, {1, 2, 0.01f}};
  s.rotation = {{1, 0, 0, 0}, {0.5f, 0.5f, 0.5f, 0.5f}};
  s.opacity = {0.5f, 1};
  for (int k = 0; k < 6 * (degree + 1) * (degree + 1); ++k) s.harmonics.push_back(float(k));
  return asset;
}

Array<double> still(int64_t points) {
  Array<double> F(points, 9);
  for (int64_t p = 0; p < points; ++p) F(p, 0) = F(p, 4) = F(p, 8) = 1;
  return F;
}

/// A PLY file cut behind its header.
struct Ply {
  std::string header, body;
  explicit Ply(const std::string& path) {
    const std::string bytes = read_file(path);
    const size_t end = bytes.find("end_header\n") + 11;
    header = bytes.substr(0, end), body = bytes.substr(end);
  }
};

TEST(PointCacheWriter, HoldsTheFramesInTheNumbersOfTheFile) {
  const test::TempFolder folder;
  const Asset asset = unit_triangle();
  const Surface surface = pose_surface(asset, 0.02);  // 2 units are 0.02 m
  const std::string path = folder.path("out.pc2");
  const auto writer = AnimationWriter::create(path, asset, surface);
  Array<double> displacement(3, 3);
  writer->frame({.displacement = displacement});
  displacement(1, 2) = 0.05;
  writer->frame({.displacement = displacement});
  EXPECT_FALSE(std::filesystem::exists(path));
  writer->finish();
  const std::string bytes = read_file(path);
  ASSERT_EQ(bytes.size(), 32u + 2 * 3 * 12);
  EXPECT_EQ(bytes.substr(0, 12), std::string("POINTCACHE2\0", 12));
  EXPECT_EQ(values_at<int32_t>(bytes, 12, 2), (std::vector{1, 3}));
  EXPECT_EQ(values_at<float>(bytes, 20, 2), (std::vector{0.0f, 1.0f}));
  EXPECT_EQ(values_at<int32_t>(bytes, 28, 1)[0], 2);
  EXPECT_EQ(values_at<float>(bytes, 32, 9), (std::vector<float>{2, 4, 6, 4, 4, 6, 2, 6, 6}));
  EXPECT_EQ(values_at<float>(bytes, 68, 9), (std::vector<float>{2, 4, 6, 4, 4, 11, 2, 6, 6}));
}

/// Two triangles with a common edge, each a mesh, whose file has them in another order.
Asset shared_edge() {
  Asset asset;
  asset.path = "shared.obj";
  for (const auto& numbers : {std::vector<int32_t>{1, 2, 3}, {0, 1, 2}}) {
    Mesh& mesh = asset.meshes.emplace_back();
    for (const int32_t k : numbers)
      mesh.position.push_back({double(k % 2), double(k / 2), 0.5 * k});
    mesh.position_of = {0, 1, 2};
    mesh.groups.push_back({-1, {0, 1, 2}, -1});
    mesh.file_position = numbers;
    asset.nodes.push_back({"", -1, kIdentity4, int(asset.meshes.size()) - 1});
  }
  return asset;
}

TEST(FrameWriters, VerticesThatMeshesShareAreWrittenOnceInTheOrderOfTheFile) {
  const test::TempFolder folder;
  const Asset asset = shared_edge();
  const Surface surface = pose_surface(asset);
  Array<double> displacement(6, 3);
  // vertex k of the file moves by k
  for (int p = 0; p < 6; ++p) displacement(p, 2) = (std::array{1, 2, 3, 0, 1, 2})[size_t(p)];
  for (const char* name : {"out.ply", "out.pc2"}) {
    const auto writer = AnimationWriter::create(folder.path(name), asset, surface);
    writer->frame({.displacement = displacement});
    writer->finish();
  }
  const std::vector<float> expected = {0, 0, 0, 1, 0, 1.5, 0, 1, 3, 1, 1, 4.5};
  const std::string cache = read_file(folder.path("out.pc2"));
  EXPECT_EQ(values_at<int32_t>(cache, 16, 1)[0], 4);
  EXPECT_EQ(values_at<float>(cache, 32, 12), expected);
  const Ply ply(folder.path("out_00000.ply"));
  expect_says(ply.header, "element vertex 4\n");
  EXPECT_EQ(values_at<float>(ply.body, 0, 12), expected);
  EXPECT_EQ(values_at<int32_t>(ply.body, 49, 3), (std::vector{1, 2, 3}));
  EXPECT_EQ(values_at<int32_t>(ply.body, 62, 3), (std::vector{0, 1, 2}));
}

TEST(PlyWriter, AMeshHasItsVerticesAndTriangles) {
  const test::TempFolder folder;
  const Asset asset = unit_triangle();
  const Surface surface = pose_surface(asset);
  const auto writer = AnimationWriter::create(folder.path("out.ply"), asset, surface);
  EXPECT_FALSE(writer->needs_gradient());
  writer->frame({.displacement = Array<double>(3, 3)});
  writer->finish();
  const Ply ply(folder.path("out_00000.ply"));
  expect_says(ply.header, "element vertex 3");
  expect_says(ply.header, "element face 1");
  EXPECT_EQ(values_at<float>(ply.body, 0, 9), (std::vector<float>{2, 4, 6, 4, 4, 6, 2, 6, 6}));
  EXPECT_EQ(ply.body[36], 3);
  EXPECT_EQ(values_at<int32_t>(ply.body, 37, 3), (std::vector{0, 1, 2}));
  EXPECT_EQ(ply.body.size(), 49u);
}

TEST(PlyWriter, ACloudMovesWithItsNormalsAndColours) {
  const test::TempFolder folder;
  const Asset asset = cloud();
  Surface surface;
  surface.scale = 0.1;
  const auto writer = AnimationWriter::create(folder.path("out.ply"), asset, surface);
  ASSERT_TRUE(writer->needs_gradient());
  Array<double> displacement(2, 3), F = still(2);
  writer->frame({.displacement = displacement, .gradient = F});
  // the second frame moves the first point and has a shear and a stretch
  displacement(0, 0) = 0.5;
  F(0, 2) = 1;  // x moves by z: F^-T turns (0, 0, 1) into itself
  F(1, 0) = 2;  // (0.6, 0.8, 0) becomes (0.3, 0.8, 0)
  writer->frame({.displacement = displacement, .gradient = F});
  writer->finish();
  // values of both frames
  const Ply rest(folder.path("out_00000.ply")), ply(folder.path("out_00001.ply"));
  ASSERT_EQ(rest.body.size(), 2u * 28);
  EXPECT_EQ(values_at<float>(rest.body, 0, 6), (std::vector<float>{1, 2, 3, 0, 0, 1}));
  EXPECT_EQ(values_at<uint8_t>(rest.body, 24, 4), (std::vector<uint8_t>{255, 0, 128, 255}));
  EXPECT_EQ(values_at<float>(rest.body, 28, 1)[0], float(1e5 + 0.1));
  EXPECT_EQ(values_at<uint8_t>(rest.body, 52, 4), (std::vector<uint8_t>{0, 255, 255, 128}));
  EXPECT_EQ(values_at<float>(ply.body, 0, 6), (std::vector<float>{6, 2, 3, 0, 0, 1}));
  const double norm = std::hypot(0.3, 0.8);
  EXPECT_NEAR(values_at<float>(ply.body, 40, 2)[0], 0.3 / norm, 1e-6);
  EXPECT_NEAR(values_at<float>(ply.body, 40, 2)[1], 0.8 / norm, 1e-6);
}

TEST(PlyWriter, OwnColumnsComeLastAsTheyWere) {
  const test::TempFolder folder;
  for (const bool of_splats : {false, true}) {
    Asset asset = of_splats ? splats(0) : cloud();
    OwnColumns& own = of_splats ? asset.splats->own : asset.points->own;
    own.columns = {{"label", PlyType::kInt16}, {"x", PlyType::kFloat64}};
    for (const int k : {0, 1}) own.add(0, -7 + k), own.add(1, 0.1 + k);
    const auto writer = AnimationWriter::create(folder.path("own.ply"), asset, kUnitScale);
    writer->frame({.displacement = Array<double>(2, 3), .gradient = still(2)});
    const Ply ply(folder.path("own_00000.ply"));
    const size_t row = ply.body.size() / 2;
    EXPECT_NE(ply.header.find("property short label\nproperty double own_x\nend_header"),
              std::string::npos);
    for (const size_t k : {0u, 1u}) {
      EXPECT_EQ(values_at<int16_t>(ply.body, (k + 1) * row - 10, 1)[0], -7 + int(k));
      EXPECT_EQ(values_at<double>(ply.body, (k + 1) * row - 8, 1)[0], 0.1 + double(k));
    }
  }
}

TEST(PlyWriter, PlacesFarFromTheOriginAreDoubles) {
  const test::TempFolder folder;
  Asset asset = splats(0);
  asset.splats->position = {{3e7, -2e7, 1e7}, {3e7 + 1, -2e7, 1e7 + 0.125}};
  const auto writer = AnimationWriter::create(folder.path("far.ply"), asset, kUnitScale);
  Array<double> displacement(2, 3);
  displacement(1, 0) = 0.015625;
  writer->frame({.displacement = displacement, .gradient = still(2)});
  const Ply ply(folder.path("far_00000.ply"));
  EXPECT_NE(ply.header.find("property double x\n"), std::string::npos);
  EXPECT_EQ(values_at<double>(ply.body, ply.body.size() / 2, 3),
            (std::vector<double>{3e7 + 1.015625, -2e7, 1e7 + 0.125}));
}

TEST(PlyWriter, SplatsHaveTheLayoutOfTheirTrainer) {
  const test::TempFolder folder;
  const Asset asset = splats(1);
  const auto writer = AnimationWriter::create(folder.path("out.ply"), asset, kUnitScale);
  ASSERT_TRUE(writer->needs_gradient());
  writer->frame({.displacement = Array<double>(2, 3), .gradient = still(2)});
  writer->finish();
  const Ply ply(folder.path("out_00000.ply"));
  // order of the properties
  size_t at = 0;
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_2", "f_rest_0",
                           "f_rest_8", "opacity", "scale_0", "scale_2", "rot_0", "rot_3"}) {
    const size_t next = ply.header.find(concat("property float ", name, '\n'));
    ASSERT_NE(next, std::string::npos) << name;
    EXPECT_GT(next, at) << name;
    at = next;
  }
  // values of the first splat, then opacity 1 and a small scale of the second
  ASSERT_EQ(ply.body.size(), 2u * 26 * 4);
  const std::vector<float> v = values_at<float>(ply.body, 0, 52);
  const float expected[18] = {0.1f, -2, 3, 0, 0, 0, 0, 1, 2, 3, 6, 9, 4, 7, 10, 5, 8, 11};
  for (size_t k = 0; k < 18; ++k) EXPECT_EQ(v[k], expected[k]) << k;
  EXPECT_NEAR(v[18], 0, 1e-6);  // logit of 1/2
  for (size_t k = 0; k < 3; ++k) EXPECT_NEAR(v[19 + k], -std::numbers::ln2 * double(k + 1), 1e-6);
  EXPECT_EQ(v[22], 1);
  EXPECT_TRUE(std::isfinite(v[26 + 18]));
  EXPECT_GT(v[26 + 18], 15);
  EXPECT_NEAR(v[26 + 21], std::log(0.01), 1e-6);
  for (size_t k = 22; k < 26; ++k) EXPECT_EQ(v[26 + k], 0.5f);
}

TEST(PlyWriter, SplatsTurnWithTheBody) {
  const test::TempFolder folder;
  const Asset asset = splats(1);
  const auto writer = AnimationWriter::create(folder.path("out.ply"), asset, kUnitScale);
  Array<double> F(2, 9);  // a quarter turn about z
  for (int64_t p = 0; p < 2; ++p) F(p, 1) = -1, F(p, 3) = F(p, 8) = 1;
  writer->frame({.displacement = Array<double>(2, 3), .gradient = F});
  const std::vector<float> v = values_at<float>(Ply(folder.path("out_00000.ply")).body, 0, 52);
  EXPECT_EQ(Ply(folder.path("out_00000.ply")).header.find("stretches"), std::string::npos);
  // red of degree 1 is C1 (-y r0 + z r1 - x r2) with r = 3, 6, 9: seen from turned directions
  // (x, y) -> (y, -x) it is C1 (x r0 + z r1 - y r2)
  EXPECT_NEAR(v[9], 9, 1e-5);
  EXPECT_NEAR(v[10], 6, 1e-5);
  EXPECT_NEAR(v[11], -3, 1e-5);
  EXPECT_NEAR(v[22], std::sqrt(0.5), 1e-6);
  EXPECT_NEAR(v[25], std::sqrt(0.5), 1e-6);
}

TEST(PlyWriter, SaysHowManySplatsWereHeldBack) {
  const test::TempFolder folder;
  const Asset asset = splats(0);
  const auto writer = AnimationWriter::create(folder.path("out.ply"), asset, kUnitScale);
  Array<double> F = still(2);
  F(1, 4) = 5;
  writer->frame({.displacement = Array<double>(2, 3), .gradient = F});
  expect_says(Ply(folder.path("out_00000.ply")).header, "stretches of 1 splats");
}

/// A cube of eight voxels, stretched, and the contents of its file.
class VtuWriterTest : public ::testing::Test {
 protected:
  VtuWriterTest() {
    scene.grid = make_box(2, 2, 2, 0.5, {0, 0, 0});
    scene.material = Array<int32_t>(8);
    scene.pinned = Array<uint8_t>(scene.grid.node_count());
    finish_scene(scene);
    state = initial_state(scene);
  }

  void map(const double (&F)[9]) {
    for (int64_t n = 0; n < scene.grid.node_count(); ++n)
      for (int i = 0; i < 3; ++i) {
        state.x(n, i) = 0.25 * i;
        for (int d = 0; d < 3; ++d) state.x(n, i) += F[3 * i + d] * scene.grid.rest(n, d);
      }
  }

  void write(const AnimationFrame& extra = {}) {
    const auto writer =
        AnimationWriter::create(folder.path("out.pvd"), {}, {}, {.scene = &scene, .tets = tets});
    AnimationFrame frame = extra;
    frame.state = &state;
    state.time = 0.25;
    writer->frame(frame);
    writer->finish();
    bytes = read_file(folder.path("out_00000.vtu"));
    data = bytes.find("encoding=\"raw\">\n_") + 17;
  }

  std::vector<float> array(const std::string& name) const {
    const size_t at = bytes.find("Name=\"" + name + '"');
    EXPECT_NE(at, std::string::npos) << name;
    const size_t offset = bytes.find("offset=\"", at) + 8;
    const size_t begin = data + std::stoul(bytes.substr(offset));
    const uint64_t size = values_at<uint64_t>(bytes, begin, 1)[0];
    return values_at<float>(bytes, begin + 8, size / sizeof(float));
  }

  test::TempFolder folder;
  Scene scene;
  const Array<int32_t>* tets = nullptr;
  State state;
  std::string bytes;
  size_t data = 0;
};

TEST_F(VtuWriterTest, HoldsTheDeformationGradient) {
  const double F[9] = {1.1, -0.4, 0.2, 0.5, 0.9, 0, -0.1, 0.3, 1.2};
  map(F);
  const Array<double> residual(scene.grid.node_count(), 3);
  write({.displacement = {}, .residual = residual});
  const std::vector<float> gradient = array("F"), x = array("Points");
  ASSERT_EQ(gradient.size(), 8u * 9);
  for (size_t k = 0; k < gradient.size(); ++k) EXPECT_NEAR(gradient[k], F[k % 9], 1e-6);
  ASSERT_EQ(x.size(), 27u * 3);
  for (size_t k = 0; k < x.size(); ++k) EXPECT_EQ(x[k], float(state.x.data()[k]));
  const double J = 1.1 * 0.9 * 1.2 + 0.4 * (0.5 * 1.2) + 0.2 * (0.5 * 0.3 + 0.9 * 0.1);
  for (const float j : array("J")) EXPECT_NEAR(j, J, 1e-6);
  for (const float fill : array("fill")) EXPECT_EQ(fill, 1);
  EXPECT_EQ(array("material").size(), 8u);
  EXPECT_EQ(array("displacement").size(), 81u);
  EXPECT_EQ(array("velocity").size(), 81u);
  EXPECT_EQ(array("residual").size(), 81u);
  expect_says(bytes, "NumberOfPoints=\"27\" NumberOfCells=\"8\"");
  const std::string pvd = read_file(folder.path("out.pvd"));
  expect_says(pvd, "timestep=\"0.25\"");
  expect_says(pvd, "file=\"out_00000.vtu\"");
}

TEST_F(VtuWriterTest, HoldsTheCauchyStressOfANeoHookeanBar) {
  // uniaxial stretch with free sides: sigma = diag(mu (s^2 - 1) + lambda ln J) / J
  const double a = 1.3, b = 0.9;
  const Material& m = scene.materials[0];
  // turned by a quarter about z: the bar lies along y
  map({0, -b, 0, a, 0, 0, 0, 0, b});
  write();
  const double J = a * b * b;
  const double along = (m.mu() * (a * a - 1) + m.lambda() * std::log(J)) / J;
  const double across = (m.mu() * (b * b - 1) + m.lambda() * std::log(J)) / J;
  const std::vector<float> stress = array("cauchy_stress");
  ASSERT_EQ(stress.size(), 8u * 6);
  const double expected[6] = {across, along, across, 0, 0, 0};
  for (size_t k = 0; k < stress.size(); ++k)
    EXPECT_NEAR(stress[k], expected[k % 6], 1e-6 * std::abs(along));
}

TEST_F(VtuWriterTest, AnInvertedVoxelHasNoStress) {
  map({-1, 0, 0, 0, 1, 0, 0, 0, 1});
  write();
  for (const float s : array("cauchy_stress")) EXPECT_TRUE(std::isnan(s));
  for (const float j : array("J")) EXPECT_EQ(j, -1);
}

TEST_F(VtuWriterTest, HexahedraAreInTheOrderOfVtk) {
  write();
  const std::vector<float> corner = array("connectivity"), x = array("Points");
  std::vector<int32_t> nodes(corner.size());
  std::memcpy(nodes.data(), corner.data(), corner.size() * 4);
  const float order[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                             {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  ASSERT_EQ(nodes.size(), 64u);
  for (size_t c = 0; c < 64; ++c)
    for (size_t d = 0; d < 3; ++d)
      EXPECT_EQ(x[3 * size_t(nodes[c]) + d],
                x[3 * size_t(nodes[c / 8 * 8]) + d] + 0.5f * order[c % 8][d]);
}

TEST_F(VtuWriterTest, TetrahedraHaveTheGradientAtTheirCentroid) {
  // x = X + X_0 X_1 e_0, which linear elements do not see at the corners
  Array<int32_t> cell(1, 10);
  scene.grid.rest = Array<double>(10, 3);
  for (int c = 0; c < 4; ++c)
    for (int d = 0; d < 3; ++d) scene.grid.rest(c, d) = c == d + 1;
  constexpr int kEdges[6][2] = {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}};
  for (int64_t n = 0; n < 10; ++n) cell(0, n) = int32_t(n);
  for (int64_t n = 4; n < 10; ++n)
    for (int d = 0; d < 3; ++d)
      for (const int end : kEdges[n - 4]) scene.grid.rest(n, d) += scene.grid.rest(end, d) / 2;
  state.x = scene.grid.rest;
  for (int64_t n = 0; n < 10; ++n) state.x(n, 0) += state.x(n, 0) * state.x(n, 1);
  Array<int32_t> linear(1, 4);
  std::copy_n(cell.data(), 4, linear.data());
  for (const int nodes : {10, 4}) {
    tets = nodes == 10 ? &cell : &linear;
    write();
    const float bent = nodes == 10 ? 0.25f : 0;
    const float F[9] = {1 + bent, bent, 0, 0, 1, 0, 0, 0, 1};
    const std::vector<float> gradient = array("F");
    ASSERT_EQ(gradient.size(), 9u);
    for (size_t k = 0; k < 9; ++k) EXPECT_NEAR(gradient[k], F[k], 1e-7);
    EXPECT_EQ(array("connectivity").size(), size_t(nodes));
    EXPECT_EQ(bytes.find("fill"), std::string::npos);
  }
}

TEST_F(VtuWriterTest, RefusesToWriteWithoutSceneOrState) {
  const auto refused = [&](const std::function<void()>& call) {
    return error_of(call, ErrorKind::kUsage);
  };
  expect_says(refused([&] { AnimationWriter::create(folder.path("a.pvd"), {}, {}); }), "scene");
  const auto writer = AnimationWriter::create(folder.path("a.pvd"), {}, {}, {.scene = &scene});
  expect_says(refused([&] { writer->frame({}); }), "state");
  expect_says(refused([&] { writer->finish(); }), "no frame");
}

TEST(FrameWriters, RefuseWhatTheyCannotWrite) {
  const test::TempFolder folder;
  Asset asset = cloud();
  const auto refused = [&](const std::string& name, const AnimationFrame& frame) {
    return error_of(
        [&] { AnimationWriter::create(folder.path(name), asset, kUnitScale)->frame(frame); },
        ErrorKind::kUsage);
  };
  // frames of a wrong shape or with numbers that are not finite
  const Array<double> none(2, 3), F = still(2);
  Array<double> bad(2, 3), bad_F = F;
  bad(1, 1) = NAN, bad_F(0, 0) = HUGE_VAL;
  expect_says(refused("out.glb", {}), "out.ply");
  for (const char* name : {"out.ply", "out.pc2"}) {
    expect_says(refused(name, {.displacement = Array<double>(3, 3), .gradient = F}), "(2, 3)");
    expect_says(refused(name, {.displacement = bad, .gradient = F}), "finite");
  }
  expect_says(refused("out.ply", {.displacement = none}), "(2, 9)");
  expect_says(refused("out.ply", {.displacement = none, .gradient = bad_F}), "finite");
  asset.path = folder.path("out_00000.ply");
  expect_says(refused("out.ply", {.displacement = none, .gradient = F}), "input");
  // folders that do not exist, then animations without a frame
  for (const char* name : {"out.ply", "out.pc2", "out.pvd"}) {
    expect_says(error_of(
                    [&] {
                      const Scene scene;
                      AnimationWriter::create(folder.path(concat("no/", name)), asset, kUnitScale,
                                              {.scene = &scene});
                    },
                    ErrorKind::kResources),
                "no/");
  }
  for (const char* name : {"out.ply", "out.pc2"})
    expect_says(
        error_of([&] { AnimationWriter::create(folder.path(name), asset, kUnitScale)->finish(); },
                 ErrorKind::kUsage),
        "no frame");
  EXPECT_TRUE(std::filesystem::is_empty(folder.path("")));
}

}  // namespace
}  // namespace elastogen
