// SPDX-License-Identifier: Apache-2.0
#include "core/error.hpp"
#include "tests/io/state_files.hpp"

namespace elastogen::test {
namespace {

constexpr int kParticles = 5;

class StateParticlesTest : public StateWriterTest {
 protected:
  /// Arrays of an entry, with numbers of their own.
  struct Entry {
    explicit Entry(int step) {
      state.x = counted<double>(kParticles, 3, step, 0.01);
      state.v = counted<double>(kParticles, 3, step, 0.02);
      state.time = step / 120.0;
      F = counted<double>(kParticles, 9, step, 0.001);
      C = counted<double>(kParticles, 9, -step, 0.003);
      memory = counted<double>(kParticles, 1, step, 0.1);
      strain = {F, C, {}, memory};
    }
    State state;
    Array<double> F, C, memory;
    ParticleStrain strain;
  };

  void write_run(int steps) {
    header.solver = "mpm";
    header.element = "particle";
    header.scheme = "euler";
    header.particles = ParticleSet{mass, volume, material};
    const Entry start(0);
    StateWriter writer(path, scene, header, start.state, &start.strain);
    for (int step = 1; step <= steps; ++step) {
      const Entry entry(step);
      writer.step(entry.state, report_at(step), &entry.strain);
    }
    StatePlastic plastic;
    plastic.yields = counted<double>(2, 5, 0, 1);
    writer.set_plastic(plastic);
    writer.finish();
    open();
  }

  Scene scene = two_voxels();
  Array<double> mass = counted<double>(kParticles, 1, 1, 0.5);
  Array<double> volume = counted<double>(kParticles, 1, 2, 0.25);
  Array<int32_t> material = counted<int32_t>(kParticles, 1, 0, 1);
};

TEST_F(StateParticlesTest, HoldsEveryEntryOfEveryParticle) {
  scene.colliders = {half_space({0, 1, 0}, 0.5, 0.25)};
  write_run(kSteps);
  // element, types and shapes
  EXPECT_EQ(text("element"), "particle");
  EXPECT_EQ(text("solver"), "mpm");
  const hid_t f64 = H5T_IEEE_F64LE;
  for (const char* name : {"x", "v", "F", "C", "memory"})
    EXPECT_TRUE(has_type((std::string("/particles/") + name).c_str(), f64)) << name;
  EXPECT_EQ(shape("/particles/x"), (std::vector<hsize_t>{kSteps + 1, kParticles, 3}));
  EXPECT_EQ(shape("/particles/F"), (std::vector<hsize_t>{kSteps + 1, kParticles, 9}));
  EXPECT_EQ(shape("/particles/memory"), (std::vector<hsize_t>{kSteps + 1, kParticles}));
  // constant arrays
  EXPECT_EQ(numbers("/particles/mass"), values_of(mass));
  EXPECT_EQ(numbers("/particles/volume"), values_of(volume));
  EXPECT_EQ(read<int32_t>("/particles/material", H5T_NATIVE_INT32), values_of(material));
  // all entries, one after the other
  std::vector<double> x, v, F, C, memory;
  for (int step = 0; step <= kSteps; ++step) {
    const Entry entry(step);
    const auto add = [](std::vector<double>& all, const Array<double>& some) {
      all.insert(all.end(), some.data(), some.data() + some.size());
    };
    add(x, entry.state.x), add(v, entry.state.v), add(F, entry.F), add(C, entry.C);
    add(memory, entry.memory);
  }
  EXPECT_EQ(numbers("/particles/x"), x);
  EXPECT_EQ(numbers("/particles/v"), v);
  EXPECT_EQ(numbers("/particles/F"), F);
  EXPECT_EQ(numbers("/particles/C"), C);
  EXPECT_EQ(numbers("/particles/memory"), memory);
  EXPECT_EQ(numbers("/plastic/yields"), values_of(counted<double>(2, 5, 0, 1)));
  EXPECT_EQ(numbers("/contact/friction"), (std::vector<double>{0.25}));
}

TEST_F(StateParticlesTest, HasNothingOfVoxels) {
  write_run(1);
  for (const char* name : {"/grid", "/contact"})
    EXPECT_EQ(H5Lexists(file, name, H5P_DEFAULT), 0) << name;
  for (const char* name : {"/steps/x", "/plastic/Fp_inverse", "/steps/energy_plastic"})
    EXPECT_EQ(H5Lexists(file, name, H5P_DEFAULT), 0) << name;
  EXPECT_EQ(H5Aexists(file, "hourglass"), 0);
}

TEST_F(StateParticlesTest, RefusesAnEntryWithoutStrain) {
  header.particles = ParticleSet{mass, volume, material};
  const Entry start(0);
  EXPECT_THROW(StateWriter(path, scene, header, start.state), Error);
  Entry other(0);
  other.F = Array<double>(kParticles, 3);
  other.strain.F = other.F;
  EXPECT_THROW(StateWriter(path, scene, header, other.state, &other.strain), Error);
  EXPECT_FALSE(fs::exists(path));
}

}  // namespace
}  // namespace elastogen::test
