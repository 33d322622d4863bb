// SPDX-License-Identifier: Apache-2.0
// A run of two voxels whose arrays have numbers of their own, written to a state file and read back
// by HDF5 alone.

#pragma once

#include "core/scene.hpp"
#include "io/state_writer.hpp"

#include <gtest/gtest.h>
#include <hdf5.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <vector>

namespace elastogen::test {

namespace fs = std::filesystem;

inline constexpr int kNodes = 12, kVoxels = 2, kSteps = 3;

template <class T>
Array<T> counted(int64_t rows, int cols, double first, double step) {
  Array<T> values(rows, cols);
  for (int64_t k = 0; k < values.size(); ++k) values.data()[k] = T(first + step * double(k));
  return values;
}

/// Two voxels in a row and two materials; every array has numbers of its own.
inline Scene two_voxels() {
  Scene scene;
  scene.grid.h = 0.25;
  scene.grid.rest = counted<double>(kNodes, 3, 0.1, 0.01);
  scene.grid.corners = counted<int32_t>(kVoxels, 8, 0, 0.5);
  scene.grid.fill = counted<double>(kVoxels, 1, 0.4, 0.2);
  scene.grid.shape_mean = counted<double>(kVoxels, 8, 0.01, 0.003);
  scene.material = counted<int32_t>(kVoxels, 1, 0, 1);
  scene.materials = {Material{}, {"a rather long name of a foam", Law::kStvk, 2e4, 0.3, 30}};
  scene.pinned = counted<uint8_t>(kNodes, 1, 0, 0.1);
  scene.mass = counted<double>(kNodes, 1, 1, 0.1);
  scene.variance = counted<double>(kVoxels, 4, 1e5, 1e3);
  scene.gravity = {0.5, -9.81, 0.25};
  scene.dt = 1.0 / 120;
  scene.scheme = TimeScheme::kBdf2;
  return scene;
}

inline State state_at(int step) {
  State state;
  state.x = counted<double>(kNodes, 3, step, 0.001);
  state.v = counted<double>(kNodes, 3, -step, 0.002);
  state.time = step / 120.0;
  return state;
}

inline StepReport report_at(int step) {
  StepReport report;
  report.step = step;
  report.scheme = step == 1 ? TimeScheme::kEuler : TimeScheme::kBdf2;
  report.converged = step != 2;
  report.length = 0.01 / step, report.tolerance = 3e-3 * step;
  report.residual = 1e-4 * step;
  report.outer = 10 + step, report.inner = 20 + step;
  report.min_j = 1 - 0.1 * step;
  report.energy = {1.0 * step, 2.0 * step, 3.0 * step, 4.0 * step, 5.0 * step};
  report.ms = 7.5 * step;
  return report;
}

class StateWriterTest : public testing::Test {
 protected:
  void SetUp() override {
    folder = fs::temp_directory_path() / ("elastogen_state_" + std::to_string(getpid()));
    fs::create_directories(folder);
    path = folder / "run.h5";
  }
  void TearDown() override {
    if (file >= 0) H5Fclose(file);
    fs::remove_all(folder);
  }

  void write(const Scene& scene, int steps = kSteps) const {
    StateWriter writer(path, scene, header, state_at(0));
    for (int step = 1; step <= steps; ++step) writer.step(state_at(step), report_at(step));
    writer.finish();
  }
  void open() { file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT); }

  std::vector<hsize_t> shape(const char* name) const {
    const hid_t dataset = H5Dopen2(file, name, H5P_DEFAULT), space = H5Dget_space(dataset);
    std::vector<hsize_t> extents(size_t(std::max(0, H5Sget_simple_extent_ndims(space))));
    H5Sget_simple_extent_dims(space, extents.data(), nullptr);
    H5Sclose(space);
    H5Dclose(dataset);
    return extents;
  }
  bool has_type(const char* name, hid_t expected) const {
    const hid_t dataset = H5Dopen2(file, name, H5P_DEFAULT), type = H5Dget_type(dataset);
    const bool same = H5Tequal(type, expected) > 0;
    H5Tclose(type);
    H5Dclose(dataset);
    return same;
  }
  template <class T>
  std::vector<T> read(const char* name, hid_t type) const {
    size_t size = 1;
    for (const hsize_t extent : shape(name)) size *= extent;
    std::vector<T> values(size);
    const hid_t dataset = H5Dopen2(file, name, H5P_DEFAULT);
    H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    H5Dclose(dataset);
    return values;
  }
  std::vector<double> numbers(const char* name) const {
    return read<double>(name, H5T_NATIVE_DOUBLE);
  }
  std::vector<double> attribute(const char* object, const char* name, int count = 1) const {
    std::vector<double> value(static_cast<size_t>(count));
    const hid_t id = H5Aopen_by_name(file, object, name, H5P_DEFAULT, H5P_DEFAULT);
    EXPECT_GE(id, 0) << name;
    H5Aread(id, H5T_NATIVE_DOUBLE, value.data());
    H5Aclose(id);
    return value;
  }
  std::string text(const char* name) const {
    const hid_t id = H5Aopen(file, name, H5P_DEFAULT), type = H5Aget_type(id);
    std::string value(H5Tget_size(type), '\0');
    H5Aread(id, type, value.data());
    H5Tclose(type);
    H5Aclose(id);
    return value.c_str();
  }

  fs::path folder, path;
  StateHeader header = {.fps = 30,
                        .solver = "quasi",
                        .tolerance = 2e-3,
                        .commit = "abc123",
                        .contact = {{"distance", 0.0625}}};
  hid_t file = -1;
};

template <class T>
std::vector<T> values_of(const Array<T>& array) {
  return {array.data(), array.data() + array.size()};
}

}  // namespace elastogen::test
