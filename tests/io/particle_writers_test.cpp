// SPDX-License-Identifier: Apache-2.0
// Particles in files, read from the bytes.
#include "io/animation_writer.hpp"
#include "io/safe_file.hpp"
#include "tests/io/test_files.hpp"

#include <cstring>

namespace elastogen::test {
namespace {

/// Two particles of numbers of their own, at (1, 2, 3) m and (4, 5, 6) m of an asset in decimetres.
struct Particles {
  Particles() {
    state.x = Array<double>(2, 3);
    state.v = Array<double>(2, 3);
    for (int k = 0; k < 6; ++k) state.x.data()[k] = k + 1, state.v.data()[k] = 0.1 * (k + 1);
    state.time = 0.125;
    F(0, 0) = F(0, 4) = F(0, 8) = 1;
    F(1, 0) = 2, F(1, 4) = 0.5, F(1, 8) = 0.75, F(1, 1) = 0.25;
    for (int k = 0; k < 12; ++k) stress.data()[k] = 100 * k;
    memory(1) = -0.5;
    mass(0) = 3, mass(1) = 4, volume(0) = 0.5, volume(1) = 0.25;
    material(1) = 7;
    asset.path = "asset.obj";
    asset.points.emplace().position = {{10, 20, 30}, {40, 50, 60}};
    surface.scale = 0.1;
    scene.place = {};
    strain = {F, C, stress, memory};
    options.scene = &scene;
    options.particles = ParticleSet{mass, volume, material};
  }

  /// Writes the second frame, moved by 1 m along x.
  void write(const std::string& path) {
    const auto writer = AnimationWriter::create(path, asset, surface, options);
    EXPECT_TRUE(writer->needs_motion());
    Array<double> u(2, 3);
    writer->frame({.displacement = u, .state = &state, .particles = &strain});
    u(0, 0) = u(1, 0) = 1;
    writer->frame({.displacement = u, .state = &state, .particles = &strain});
    writer->finish();
  }

  State state;
  Array<double> F{2, 9}, C{2, 9}, stress{2, 6}, memory{2}, mass{2}, volume{2};
  Array<int32_t> material{2};
  Asset asset;
  Surface surface;
  Scene scene;
  ParticleStrain strain;
  AnimationOptions options;
};

template <class T>
std::vector<T> values(const std::string& bytes, size_t at, size_t count) {
  std::vector<T> result(count);
  EXPECT_LE(at + count * sizeof(T), bytes.size());
  std::memcpy(result.data(), bytes.data() + at, count * sizeof(T));
  return result;
}

TEST(ParticlePly, HasVelocityVolumeRatioMemoryAndMaterial) {
  const TempFolder folder;
  Particles of;
  of.write(folder.path("a.ply"));
  const std::string bytes = read_file(folder.path("a_00001.ply"));
  const std::string head =
      "element vertex 2\nproperty float x\nproperty float y\nproperty float z\nproperty float vx\n"
      "property float vy\nproperty float vz\nproperty float J\nproperty float memory\n"
      "property int material\nend_header\n";
  const size_t at = bytes.find(head);
  ASSERT_NE(at, std::string::npos) << bytes;
  const size_t row = 8 * sizeof(float) + sizeof(int32_t), begin = at + head.size();
  ASSERT_EQ(bytes.size(), begin + 2 * row);
  // lengths in decimetres, as the asset has them
  EXPECT_EQ(values<float>(bytes, begin, 8), (std::vector<float>{20, 20, 30, 1, 2, 3, 1, 0}));
  EXPECT_EQ(values<float>(bytes, begin + row, 8),
            (std::vector<float>{50, 50, 60, 4, 5, 6, 0.75f, -0.5f}));
  EXPECT_EQ(values<int32_t>(bytes, begin + 32, 1)[0], 0);
  EXPECT_EQ(values<int32_t>(bytes, begin + row + 32, 1)[0], 7);
}

/// Numbers of an array that is appended to a VTU file.
template <class T>
std::vector<T> vtu_array(const std::string& bytes, const std::string& name) {
  const size_t at = bytes.find("Name=\"" + name + '"');
  const size_t offset = bytes.find("offset=\"", at) + 8;
  const size_t data = bytes.find("<AppendedData encoding=\"raw\">\n_") + 31 +
                      size_t(std::stoll(bytes.substr(offset)));
  return values<T>(bytes, data + 8, values<uint64_t>(bytes, data, 1)[0] / sizeof(T));
}

TEST(ParticleVtu, HasVerticesWithStrainAndStress) {
  const TempFolder folder;
  Particles of;
  of.write(folder.path("a.pvd"));
  const std::string bytes = read_file(folder.path("a_00001.vtu"));
  expect_says(bytes, "NumberOfPoints=\"2\" NumberOfCells=\"2\"");
  using Floats = std::vector<float>;
  EXPECT_EQ(vtu_array<float>(bytes, "Points"), (Floats{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(vtu_array<float>(bytes, "velocity"), (Floats{0.1f, 0.2f, 0.3f, 0.4f, 0.5f, 0.6f}));
  EXPECT_EQ(vtu_array<float>(bytes, "J"), (Floats{1, 0.75f}));
  EXPECT_EQ(vtu_array<float>(bytes, "F")[10], 0.25f);
  EXPECT_EQ(vtu_array<float>(bytes, "memory"), (Floats{0, -0.5f}));
  EXPECT_EQ(vtu_array<float>(bytes, "kirchhoff_stress")[7], 700);
  EXPECT_EQ(vtu_array<float>(bytes, "mass"), (Floats{3, 4}));
  EXPECT_EQ(vtu_array<float>(bytes, "volume"), (Floats{0.5f, 0.25f}));
  EXPECT_EQ(vtu_array<int32_t>(bytes, "material"), (std::vector<int32_t>{0, 7}));
  EXPECT_EQ(vtu_array<int32_t>(bytes, "connectivity"), (std::vector<int32_t>{0, 1}));
  EXPECT_EQ(vtu_array<int64_t>(bytes, "offsets"), (std::vector<int64_t>{1, 2}));
  EXPECT_EQ(vtu_array<uint8_t>(bytes, "types"), (std::vector<uint8_t>{1, 1}));
  const std::string pvd = read_file(folder.path("a.pvd"));
  expect_says(pvd, "timestep=\"0.125\" part=\"0\" file=\"a_00001.vtu\"");
}

TEST(ParticleWriters, NeedTheStateAndTheStrain) {
  const TempFolder folder;
  Particles of;
  const Array<double> u(2, 3);
  for (const char* name : {"a.ply", "a.pvd"}) {
    const auto writer =
        AnimationWriter::create(folder.path(name), of.asset, of.surface, of.options);
    expect_says(error_of([&] { writer->frame({.displacement = u}); }, ErrorKind::kUsage),
                "must come with");
    expect_says(error_of([&] { writer->frame({.displacement = u, .state = &of.state}); },
                         ErrorKind::kUsage),
                "must come with");
  }
}

TEST(ParticleWriters, RefuseSurfacesWhereThereAreNoParticles) {
  const Particles of;
  for (const char* name : {"a.obj", "a.vdb"})
    expect_says(error_of([&] { AnimationWriter::create(name, of.asset, of.surface, {}); },
                         ErrorKind::kUsage),
                "this run has none");
}

}  // namespace
}  // namespace elastogen::test
