// SPDX-License-Identifier: Apache-2.0
#include "core/error.hpp"
#include "tests/io/state_files.hpp"

namespace elastogen::test {
namespace {

TEST_F(StateWriterTest, RootSaysWhatTheRunWas) {
  write(two_voxels());
  open();
  EXPECT_EQ(text("format"), "elastogen-state");
  EXPECT_EQ(text("time_scheme"), "bdf2");
  EXPECT_EQ(text("hourglass"), "full");
  EXPECT_EQ(text("solver"), "quasi");
  EXPECT_EQ(text("energy"), "analytic");
  EXPECT_EQ(text("commit"), "abc123");
  EXPECT_EQ(attribute("/", "version")[0], 5);
  EXPECT_EQ(text("element"), "voxel");
  EXPECT_EQ(attribute("/", "h")[0], 0.25);
  EXPECT_EQ(attribute("/", "dt")[0], 1.0 / 120);
  EXPECT_EQ(attribute("/", "g_ref")[0], 9.81);
  EXPECT_EQ(attribute("/", "fps")[0], 30);
  EXPECT_EQ(attribute("/", "tolerance")[0], 2e-3);
  EXPECT_EQ(attribute("/", "gravity", 3), (std::vector<double>{0.5, -9.81, 0.25}));
}

struct Row {
  const char* name;
  hid_t type;
  std::vector<hsize_t> extents;
};

TEST_F(StateWriterTest, HasTheShapesAndTypesOfTheDocumentation) {
  write(two_voxels());
  open();
  // docs/formats.md, section of state files
  const hid_t f64 = H5T_IEEE_F64LE, i32 = H5T_STD_I32LE, u8 = H5T_STD_U8LE;
  const Row rows[] = {
      {"/grid/rest", f64, {kNodes, 3}},
      {"/grid/corners", i32, {kVoxels, 8}},
      {"/grid/fill", f64, {kVoxels}},
      {"/grid/shape_mean", f64, {kVoxels, 8}},
      {"/grid/mass", f64, {kNodes}},
      {"/grid/pinned", u8, {kNodes}},
      {"/grid/hourglass", f64, {kVoxels, 4}},
      {"/grid/material", i32, {kVoxels}},
      {"/steps/time", f64, {kSteps + 1}},
      {"/steps/x", f64, {kSteps + 1, kNodes, 3}},
      {"/steps/v", f64, {kSteps + 1, kNodes, 3}},
      {"/steps/scheme", u8, {kSteps}},
      {"/steps/length", f64, {kSteps}},
      {"/steps/tolerance", f64, {kSteps}},
      {"/steps/residual", f64, {kSteps}},
      {"/steps/converged", u8, {kSteps}},
      {"/steps/outer", i32, {kSteps}},
      {"/steps/inner", i32, {kSteps}},
      {"/steps/ms", f64, {kSteps}},
      {"/steps/energy_kinetic", f64, {kSteps}},
      {"/steps/energy_elastic", f64, {kSteps}},
      {"/steps/energy_hourglass", f64, {kSteps}},
      {"/steps/energy_gravity", f64, {kSteps}},
      {"/steps/energy_contact", f64, {kSteps}},
      {"/steps/min_j", f64, {kSteps}},
  };
  for (const Row& row : rows) {
    EXPECT_EQ(shape(row.name), row.extents) << row.name;
    EXPECT_TRUE(has_type(row.name, row.type)) << row.name;
  }
}

/// Tetrahedra in place of the grid, with a node that no voxel has.
TEST_F(StateWriterTest, AMeshTakesThePlaceOfTheGrid) {
  const int nodes = kNodes + 1;
  // a mesh with loads in place of the grid
  StateMesh mesh;
  mesh.nodes.grid.rest = counted<double>(nodes, 3, 0.2, 0.03);
  mesh.corners = counted<int32_t>(5, 10, 0, 0.25);
  mesh.mass = counted<double>(nodes, 1, 2, 0.1);
  mesh.nodes.pinned = counted<uint8_t>(nodes, 1, 0, 0.1);
  mesh.material = counted<int32_t>(5, 1, 0, 0.3);
  header.element = "tet10";
  header.scheme = "newmark";
  header.solver = "fem";
  header.mesh = mesh;
  header.fixed = counted<uint8_t>(nodes, 3, 0, 0.03);
  header.traction = counted<double>(nodes, 3, -1, 0.5);
  // one step
  State state;
  state.x = counted<double>(nodes, 3, 1, 0.001);
  state.v = counted<double>(nodes, 3, -1, 0.002);
  const Scene scene = two_voxels();
  StateWriter writer(path, scene, header, state);
  writer.step(state, report_at(1));
  writer.finish();
  // the file has the mesh, and no fields of voxels
  open();
  EXPECT_EQ(text("element"), "tet10");
  EXPECT_EQ(text("time_scheme"), "newmark");
  EXPECT_EQ(numbers("/grid/rest"), values_of(mesh.nodes.grid.rest));
  EXPECT_EQ(read<int32_t>("/grid/corners", H5T_NATIVE_INT32), values_of(mesh.corners));
  EXPECT_EQ(shape("/grid/corners"), (std::vector<hsize_t>{5, 10}));
  EXPECT_EQ(shape("/steps/x"), (std::vector<hsize_t>{2, hsize_t(nodes), 3}));
  EXPECT_EQ(read<uint8_t>("/grid/fixed", H5T_NATIVE_UINT8), values_of(header.fixed));
  EXPECT_EQ(numbers("/grid/traction"), values_of(header.traction));
  EXPECT_EQ(shape("/grid/fixed"), (std::vector<hsize_t>{hsize_t(nodes), 3}));
  for (const char* name : {"fill", "shape_mean", "hourglass"})
    EXPECT_LE(H5Lexists(file, concat("/grid/", name).c_str(), H5P_DEFAULT), 0) << name;
}

TEST_F(StateWriterTest, GivesBackTheGrid) {
  const Scene scene = two_voxels();
  write(scene);
  open();
  EXPECT_EQ(numbers("/grid/rest"), values_of(scene.grid.rest));
  EXPECT_EQ(numbers("/grid/fill"), values_of(scene.grid.fill));
  EXPECT_EQ(numbers("/grid/shape_mean"), values_of(scene.grid.shape_mean));
  EXPECT_EQ(numbers("/grid/mass"), values_of(scene.mass));
  EXPECT_EQ(numbers("/grid/hourglass"), values_of(scene.variance));
  EXPECT_EQ(read<int32_t>("/grid/corners", H5T_NATIVE_INT32), values_of(scene.grid.corners));
  EXPECT_EQ(read<int32_t>("/grid/material", H5T_NATIVE_INT32), values_of(scene.material));
  EXPECT_EQ(read<uint8_t>("/grid/pinned", H5T_NATIVE_UINT8), values_of(scene.pinned));
  for (const char* name : {"/grid/fixed", "/grid/traction"})
    EXPECT_LE(H5Lexists(file, name, H5P_DEFAULT), 0) << name;
}

TEST_F(StateWriterTest, GivesBackEveryStepToTheBitAfterTheStart) {
  write(two_voxels());
  open();
  const std::vector<double> x = numbers("/steps/x"), v = numbers("/steps/v");
  const std::vector<double> time = numbers("/steps/time");
  for (int entry = 0; entry <= kSteps; ++entry) {
    const State expected = state_at(entry);
    EXPECT_EQ(time[entry], expected.time);
    for (int k = 0; k < 3 * kNodes; ++k) {
      EXPECT_EQ(x[3 * kNodes * entry + k], expected.x.data()[k]);
      EXPECT_EQ(v[3 * kNodes * entry + k], expected.v.data()[k]);
    }
  }
}

TEST_F(StateWriterTest, GivesBackEveryReport) {
  write(two_voxels());
  open();
  for (int t = 0; t < kSteps; ++t) {
    const StepReport expected = report_at(t + 1);
    EXPECT_EQ(numbers("/steps/scheme")[t], double(expected.scheme));
    EXPECT_EQ(numbers("/steps/length")[t], expected.length);
    EXPECT_EQ(numbers("/steps/tolerance")[t], expected.tolerance);
    EXPECT_EQ(numbers("/steps/residual")[t], expected.residual);
    EXPECT_EQ(numbers("/steps/converged")[t], expected.converged);
    EXPECT_EQ(numbers("/steps/outer")[t], expected.outer);
    EXPECT_EQ(numbers("/steps/inner")[t], expected.inner);
    EXPECT_EQ(numbers("/steps/ms")[t], expected.ms);
    EXPECT_EQ(numbers("/steps/energy_kinetic")[t], expected.energy.kinetic);
    EXPECT_EQ(numbers("/steps/energy_elastic")[t], expected.energy.elastic);
    EXPECT_EQ(numbers("/steps/energy_hourglass")[t], expected.energy.hourglass);
    EXPECT_EQ(numbers("/steps/energy_gravity")[t], expected.energy.gravity);
    EXPECT_EQ(numbers("/steps/energy_contact")[t], expected.energy.contact);
    EXPECT_EQ(numbers("/steps/min_j")[t], expected.min_j);
  }
}

TEST_F(StateWriterTest, NamesTheMaterials) {
  Scene scene = two_voxels();
  scene.materials[0].loss_factor = 0.25;
  scene.materials[0].loss_frequency = 7;
  write(scene);
  open();
  // a row as the file has it
  struct Row {
    char name[40], law[40];
    double young, poisson, density, loss_factor, loss_frequency;
  };
  const hid_t name = H5Tcopy(H5T_C_S1);
  H5Tset_size(name, 40);
  H5Tset_cset(name, H5T_CSET_UTF8);
  const hid_t type = H5Tcreate(H5T_COMPOUND, sizeof(Row));
  H5Tinsert(type, "name", HOFFSET(Row, name), name);
  H5Tinsert(type, "law", HOFFSET(Row, law), name);
  H5Tinsert(type, "young", HOFFSET(Row, young), H5T_NATIVE_DOUBLE);
  H5Tinsert(type, "poisson", HOFFSET(Row, poisson), H5T_NATIVE_DOUBLE);
  H5Tinsert(type, "density", HOFFSET(Row, density), H5T_NATIVE_DOUBLE);
  H5Tinsert(type, "loss_factor", HOFFSET(Row, loss_factor), H5T_NATIVE_DOUBLE);
  H5Tinsert(type, "loss_frequency", HOFFSET(Row, loss_frequency), H5T_NATIVE_DOUBLE);
  const std::vector<Row> rows = read<Row>("/materials", type);
  H5Tclose(type);
  H5Tclose(name);
  // every material, in order
  ASSERT_EQ(rows.size(), scene.materials.size());
  for (size_t m = 0; m < rows.size(); ++m) {
    EXPECT_EQ(rows[m].name, scene.materials[m].name);
    EXPECT_EQ(rows[m].law, law_name(scene.materials[m].law));
    EXPECT_EQ(rows[m].young, scene.materials[m].young);
    EXPECT_EQ(rows[m].poisson, scene.materials[m].poisson);
    EXPECT_EQ(rows[m].density, scene.materials[m].density);
    EXPECT_EQ(rows[m].loss_factor, scene.materials[m].loss_factor.value_or(0));
    EXPECT_EQ(rows[m].loss_frequency, scene.materials[m].loss_frequency);
  }
}

TEST_F(StateWriterTest, DescribesCollidersAndWhereTheyAreAtEveryEntry) {
  Scene scene = two_voxels();
  write(scene);
  open();
  EXPECT_EQ(H5Lexists(file, "contact", H5P_DEFAULT), 0);
  H5Fclose(file);
  Collider ball, box = half_space({1, 0, 0}, 0, 0);
  ball.name = "ball";
  ball.shape = Collider::Shape::kSphere;
  ball.centre = {1, 2, 3};
  ball.radius = 0.75;
  ball.path = {{0, {0, 0, 0}}, {2.0 / 120, {0.5, 0, -1}}};
  box.name = "a box";
  box.shape = Collider::Shape::kBox;
  box.half = {0.1, 0.2, 0.3};
  scene.colliders = {half_space({0, 0, 1}, -0.5, 0.3), ball, box};
  scene.surface.voxel = counted<int32_t>(5, 1, 0, 0.3);
  scene.surface.weights = counted<double>(5, 8, 0, 0.01);
  scene.surface.area = counted<double>(5, 1, 1, 1);
  write(scene);
  open();
  using Numbers = std::vector<double>;
  EXPECT_EQ(read<uint8_t>("/contact/shape", H5T_NATIVE_UINT8), (std::vector<uint8_t>{0, 1, 2}));
  EXPECT_EQ(numbers("/contact/centre"), (Numbers{0, 0, -0.5, 1, 2, 3, 0, 0, 0}));
  EXPECT_EQ(numbers("/contact/normal"), (Numbers{0, 0, 1, 0, 1, 0, 1, 0, 0}));
  EXPECT_EQ(numbers("/contact/radius"), (Numbers{0, 0.75, 0}));
  EXPECT_EQ(numbers("/contact/half"), (Numbers{0, 0, 0, 0, 0, 0, 0.1, 0.2, 0.3}));
  EXPECT_EQ(numbers("/contact/friction"), (Numbers{0.3, 0.5, 0}));
  // the path is half over after one step, and over after two
  EXPECT_EQ(shape("/contact/offset"), (std::vector<hsize_t>{kSteps + 1, 3, 3}));
  const Numbers offset = numbers("/contact/offset");
  const Numbers ball_x = {offset[3], offset[12], offset[21], offset[30]};
  EXPECT_EQ(ball_x, (Numbers{0, 0.25, 0.5, 0.5}));
  EXPECT_EQ(offset[9 * 3 + 5], -1);
  EXPECT_EQ(offset[9 * 3 + 0], 0);
  const hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, 8);
  char names[3][8];
  const hid_t dataset = H5Dopen2(file, "/contact/name", H5P_DEFAULT);
  H5Tset_cset(type, H5T_CSET_UTF8);
  EXPECT_GE(H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, names), 0);
  H5Dclose(dataset);
  H5Tclose(type);
  EXPECT_STREQ(names[0], "floor");
  EXPECT_STREQ(names[1], "ball");
  EXPECT_STREQ(names[2], "a box");
  EXPECT_EQ(attribute("/contact", "distance")[0], 0.0625);
  EXPECT_EQ(numbers("/contact/weights"), values_of(scene.surface.weights));
  EXPECT_EQ(numbers("/contact/area"), values_of(scene.surface.area));
  EXPECT_EQ(shape("/contact/voxel"), (std::vector<hsize_t>{5}));
}

}  // namespace
}  // namespace elastogen::test
