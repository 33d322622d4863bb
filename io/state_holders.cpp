// SPDX-License-Identifier: Apache-2.0
#include "io/state_holders.hpp"

#include "core/held_nodes.hpp"
#include "io/state_parts.hpp"

#include <algorithm>

namespace elastogen {

void write_dependent(hid_t group, const DependentNodes& dependent) {
  int64_t rows = 0;
  for (int64_t i = 0; i < dependent.count(); ++i) rows += dependent.parents(i).rows;
  Array<int32_t> nodes(rows), parents(rows);
  Array<double> weights(rows);
  int64_t row = 0;
  for (int64_t i = 0; i < dependent.count(); ++i)
    for (int64_t k = 0; k < dependent.parents(i).rows; ++k, ++row) {
      nodes(row) = dependent.node(i);
      parents(row) = dependent.parents(i)(k);
      weights(row) = dependent.weights(i)(k);
    }
  hdf5::write_dataset<int32_t>(group, "dependent", nodes);
  hdf5::write_dataset<int32_t>(group, "parent", parents);
  hdf5::write_dataset<double>(group, "parent_weight", weights);
}

namespace {

/// What the motion of each holder is at each time: rates, and what changes them in a second.
void write_motion(hid_t group, const Scene& scene, HeldNodes& held, const StateHeader& header,
                  const std::vector<double>& times) {
  const auto count = int64_t(scene.holders.size());
  Array<uint8_t> turns(count);
  Array<double> centre(count, 3), rate(count, 3), change(count, 3);
  for (int64_t h = 0; h < count; ++h) {
    turns(h) = scene.holders[size_t(h)].turns;
    std::ranges::copy(scene.holders[size_t(h)].centre, centre.row(h));
  }
  hdf5::write_dataset<uint8_t>(group, "turns", turns);
  hdf5::write_dataset<double>(group, "centre", centre);
  const std::vector<hsize_t> extents = {hsize_t(times.size()), hsize_t(count), hsize_t(3)};
  const hdf5::Handle rates = hdf5::create_dataset(group, "rate", H5T_IEEE_F64LE, extents),
                     changes = hdf5::create_dataset(group, "change", H5T_IEEE_F64LE, extents);
  for (size_t t = 0; t < times.size(); ++t) {
    held.set_time(header.path_time * times[t]);
    for (int64_t h = 0; h < count; ++h) {
      std::ranges::copy(held.rates()[size_t(h)].rate, rate.row(h));
      std::ranges::copy(held.rates()[size_t(h)].change, change.row(h));
    }
    hdf5::write_entry(rates, t, rate);
    hdf5::write_entry(changes, t, change);
  }
}

}  // namespace

void write_holders(hid_t file, const Scene& of_grid, const StateHeader& header,
                   const std::vector<double>& times) {
  const Scene& scene = header.mesh ? header.mesh->nodes : of_grid;
  if (scene.holders.empty()) return;
  const hdf5::Handle group = hdf5::create_group(file, "holders");
  std::vector<std::string> names;
  for (const Holder& holder : scene.holders) names.push_back(holder.name);
  write_names(group, names);
  hdf5::write_dataset<int32_t>(group, "of_node", scene.holder);
  if (!scene.fixed.empty()) hdf5::write_dataset<int32_t>(group, "of_component", scene.fixed);
  HeldNodes held(scene);
  if (!held.move()) return;
  write_motion(group, scene, held, header, times);
  // offsets of dependent nodes
  if (!held.moves_dependent()) return;
  const int64_t count = scene.dependent.count();
  const hdf5::Handle offsets = hdf5::create_dataset(
      group, "offset", H5T_IEEE_F64LE, {hsize_t(times.size()), hsize_t(count), hsize_t(3)});
  Array<double> values(count, 3);
  for (size_t t = 0; t < times.size(); ++t) {
    held.set_time(header.path_time * times[t]);
    for (int64_t i = 0; i < count; ++i) std::ranges::copy(held.offset(i), values.row(i));
    hdf5::write_entry(offsets, t, values);
  }
}

void write_reactions(hid_t group, size_t holders, const std::vector<Reaction>& reactions) {
  if (holders == 0 || reactions.empty()) return;
  const auto write = [&](const char* name, Vec3 Reaction::*part) {
    const hdf5::Handle dataset = hdf5::create_dataset(
        group, name, H5T_IEEE_F64LE, {hsize_t(reactions.size() / holders), holders, hsize_t(3)});
    Array<double> values(int64_t(holders), 3);
    for (size_t t = 0; t < reactions.size() / holders; ++t) {
      for (size_t h = 0; h < holders; ++h)
        std::ranges::copy(reactions[t * holders + h].*part, values.row(int64_t(h)));
      hdf5::write_entry(dataset, t, values);
    }
  };
  write("reaction_force", &Reaction::force);
  write("reaction_moment", &Reaction::moment);
  write("reaction_about", &Reaction::about);
}

}  // namespace elastogen
