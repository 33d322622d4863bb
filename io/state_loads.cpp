// SPDX-License-Identifier: Apache-2.0
#include "io/state_loads.hpp"

#include <algorithm>

namespace elastogen {
namespace {

void write_forces(hid_t file, const std::vector<TimedForce>& forces,
                  const std::vector<double>& times) {
  const auto count = int64_t(forces.size());
  Array<double> share(count, int(forces.front().share.rows()));
  for (int64_t k = 0; k < count; ++k)
    std::copy_n(forces[size_t(k)].share.data(), share.cols(), share.row(k));
  const hdf5::Handle group = hdf5::create_group(file, "forces");
  hdf5::write_dataset<double>(group, "share", share);
  const hdf5::Handle dataset = hdf5::create_dataset(
      group, "force", H5T_IEEE_F64LE, {hsize_t(times.size() - 1), hsize_t(count), hsize_t(3)});
  Array<double> force(count, 3);
  for (size_t t = 1; t < times.size(); ++t) {
    for (int64_t k = 0; k < count; ++k)
      std::ranges::copy(offset_at(forces[size_t(k)].force, times[t]), force.row(k));
    hdf5::write_entry(dataset, t - 1, force);
  }
}

void write_wind(hid_t file, const Wind& wind, const std::vector<double>& times) {
  const hdf5::Handle group = hdf5::create_group(file, "wind");
  hdf5::write_attribute(group, "density", wind.density);
  hdf5::write_attribute(group, "share", wind.share);
  hdf5::write_dataset<int32_t>(group, "voxel", wind.voxel);
  hdf5::write_dataset<double>(group, "weights", wind.weights);
  hdf5::write_dataset<double>(group, "area", wind.area);
  Array<double> velocity(int64_t(times.size()) - 1, 3);
  for (int64_t t = 0; t < velocity.rows(); ++t)
    std::ranges::copy(offset_at(wind.velocity, times[size_t(t) + 1]), velocity.row(t));
  hdf5::write_dataset<double>(group, "velocity", velocity);
}

}  // namespace

bool has_changing_loads(const Scene& scene, const StateHeader& header) {
  return !header.forces.empty() || scene.wind.blows();
}

void write_loads(hid_t file, const Scene& scene, const StateHeader& header,
                 const std::vector<double>& times) {
  if (times.size() < 2) return;
  if (!header.forces.empty()) write_forces(file, header.forces, times);
  if (scene.wind.blows()) write_wind(file, scene.wind, times);
}

}  // namespace elastogen
