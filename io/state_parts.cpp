// SPDX-License-Identifier: Apache-2.0
#include "io/state_parts.hpp"

#include <algorithm>
#include <cstring>
#include <iterator>

namespace elastogen {
namespace {

/// A text type of fixed length that holds the longest name.
hdf5::Handle text_type(size_t longest) {
  hdf5::Handle type(H5Tcopy(H5T_C_S1), H5Tclose, "text type");
  hdf5::check(H5Tset_size(type, longest + 1), "text type");
  hdf5::check(H5Tset_cset(type, H5T_CSET_UTF8), "text type");
  return type;
}

/// Numbers of a material in /materials.
constexpr const char* kNumbers[] = {"young", "poisson", "density", "loss_factor", "loss_frequency"};
constexpr size_t kNumberBytes = sizeof(double) * std::size(kNumbers);

/// Rows of /materials in memory: name and law of `text` bytes each, then the numbers.
std::vector<char> material_rows(const std::vector<Material>& materials, size_t text) {
  const size_t row = 2 * text + kNumberBytes;
  std::vector<char> rows(row * materials.size());
  for (size_t m = 0; m < materials.size(); ++m) {
    const Material& material = materials[m];
    const double numbers[] = {material.young, material.poisson, material.density,
                              material.loss_factor.value_or(0), material.loss_frequency};
    char* at = rows.data() + row * m;
    std::copy(material.name.begin(), material.name.end(), at);
    const std::string law = law_name(material.law);
    std::copy(law.begin(), law.end(), at + text);
    static_assert(sizeof(numbers) == kNumberBytes);
    std::memcpy(at + 2 * text, numbers, sizeof(numbers));
  }
  return rows;
}

std::vector<std::string> names_of(const std::vector<Collider>& colliders) {
  std::vector<std::string> names;
  for (const Collider& c : colliders) names.push_back(c.name);
  return names;
}

/// Writes the properties of the colliders that do not change.
void write_colliders(hid_t group, const std::vector<Collider>& colliders) {
  const auto count = int64_t(colliders.size());
  Array<uint8_t> shape(count);
  Array<double> centre(count, 3), normal(count, 3), half(count, 3), radius(count), friction(count);
  for (int64_t c = 0; c < count; ++c) {
    const Collider& collider = colliders[size_t(c)];
    shape(c) = uint8_t(collider.shape);
    std::copy(collider.centre.begin(), collider.centre.end(), centre.row(c));
    std::copy(collider.normal.begin(), collider.normal.end(), normal.row(c));
    std::copy(collider.half.begin(), collider.half.end(), half.row(c));
    radius(c) = collider.radius;
    friction(c) = collider.friction;
  }
  hdf5::write_dataset<uint8_t>(group, "shape", shape);
  hdf5::write_dataset<double>(group, "centre", centre);
  hdf5::write_dataset<double>(group, "normal", normal);
  hdf5::write_dataset<double>(group, "half", half);
  hdf5::write_dataset<double>(group, "radius", radius);
  hdf5::write_dataset<double>(group, "friction", friction);
  write_names(group, names_of(colliders));
}

/// Writes offsets of the colliders at every entry, (entries, colliders, 3).
void write_offsets(hid_t group, const std::vector<Collider>& colliders,
                   const std::vector<double>& times) {
  const hdf5::Handle dataset =
      hdf5::create_dataset(group, "offset", H5T_IEEE_F64LE, {times.size(), colliders.size(), 3});
  Array<double> offsets(int64_t(colliders.size()), 3);
  for (size_t entry = 0; entry < times.size(); ++entry) {
    for (size_t c = 0; c < colliders.size(); ++c) {
      const Vec3 offset = offset_at(colliders[c], times[entry]);
      std::copy(offset.begin(), offset.end(), offsets.row(int64_t(c)));
    }
    hdf5::write_entry(dataset, entry, offsets);
  }
}

/// Writes the points that touch colliders.
void write_surface(hid_t group, const Scene& scene, const StateHeader& header) {
  if (header.mesh) {
    hdf5::write_dataset<int32_t>(group, "nodes", header.mesh->contact_nodes);
  } else {
    hdf5::write_dataset<int32_t>(group, "voxel", scene.surface.voxel);
  }
  hdf5::write_dataset<double>(group, "weights",
                              header.mesh ? header.mesh->contact_weights : scene.surface.weights);
  hdf5::write_dataset<double>(group, "area", scene.surface.area);
}

}  // namespace

void write_names(hid_t group, const std::vector<std::string>& names) {
  size_t longest = 0;
  for (const std::string& name : names) longest = std::max(longest, name.size());
  std::vector<char> rows((longest + 1) * names.size());
  for (size_t k = 0; k < names.size(); ++k)
    std::ranges::copy(names[k], rows.data() + (longest + 1) * k);
  const hdf5::Handle type = text_type(longest);
  const hdf5::Handle dataset = hdf5::create_dataset(group, "name", type, {names.size()});
  hdf5::check(H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, rows.data()), "name");
}

void write_materials(hid_t file, const std::vector<Material>& materials) {
  size_t longest = 0;
  for (const Material& m : materials)
    longest = std::max({longest, m.name.size(), law_name(m.law).size()});
  const size_t text = longest + 1;
  const hdf5::Handle name = text_type(longest);
  const hdf5::Handle type(H5Tcreate(H5T_COMPOUND, 2 * text + kNumberBytes), H5Tclose, "materials");
  hdf5::check(H5Tinsert(type, "name", 0, name), "materials");
  hdf5::check(H5Tinsert(type, "law", text, name), "materials");
  for (size_t k = 0; k < std::size(kNumbers); ++k)
    hdf5::check(H5Tinsert(type, kNumbers[k], 2 * text + k * sizeof(double), H5T_NATIVE_DOUBLE),
                "materials");
  const hdf5::Handle dataset = hdf5::create_dataset(file, "materials", type, {materials.size()});
  const std::vector<char> rows = material_rows(materials, text);
  hdf5::check(H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, rows.data()), "materials");
}

void write_contact(hid_t file, const Scene& scene, const StateHeader& header,
                   const std::vector<double>& times) {
  if (scene.colliders.empty()) return;
  const hdf5::Handle group = hdf5::create_group(file, "contact");
  for (const auto& [name, value] : header.contact)
    hdf5::write_attribute(group, name.c_str(), value);
  if (!header.particles) write_surface(group, scene, header);
  write_colliders(group, scene.colliders);
  write_offsets(group, scene.colliders, times);
}

}  // namespace elastogen
