// SPDX-License-Identifier: Apache-2.0
#include "io/state_writer.hpp"

#include "core/constants.hpp"
#include "core/error.hpp"
#include "core/scene.hpp"
#include "core/time_scheme.hpp"
#include "io/hdf5_file.hpp"
#include "io/safe_file.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <mutex>

namespace elastogen {

namespace {

const char* hourglass_name(Hourglass hourglass) {
  switch (hourglass) {
    case Hourglass::kFull:
      return "full";
    case Hourglass::kVariance:
      return "variance";
    default:
      return "off";
  }
}

[[noreturn]] void fail(const std::string& path, const char* action) {
  throw Error(concat(path, ": ", action, " failed: ", std::strerror(errno)), ErrorKind::kResources);
}

void write_root(hid_t file, const Scene& scene, const StateHeader& header) {
  const double gravity[3] = {scene.gravity[0], scene.gravity[1], scene.gravity[2]};
  const double place[3] = {scene.place[0], scene.place[1], scene.place[2]};
  hdf5::write_attribute(file, "format", std::string("elastogen-state"));
  hdf5::write_attribute(file, "version", 3);
  hdf5::write_attribute(file, "h", scene.grid.h);
  hdf5::write_attribute(file, "dt", scene.dt);
  hdf5::write_attribute(file, "time_scheme",
                        header.scheme.empty() ? scheme_name(scene.scheme) : header.scheme);
  hdf5::write_attribute(file, "element", header.element);
  if (!header.particles)
    hdf5::write_attribute(file, "hourglass", std::string(hourglass_name(scene.hourglass)));
  hdf5::write_attribute(file, "gravity", gravity);
  hdf5::write_attribute(file, "place", place);
  hdf5::write_attribute(file, "g_ref", kReferenceGravity);
  hdf5::write_attribute(file, "fps", header.fps);
  hdf5::write_attribute(file, "solver", header.solver);
  hdf5::write_attribute(file, "tolerance", header.tolerance);
  hdf5::write_attribute(file, "energy", header.energy);
  hdf5::write_attribute(file, "commit", header.commit);
}

void write_mesh(hid_t file, const StateMesh& mesh) {
  const hdf5::Handle group = hdf5::create_group(file, "grid");
  hdf5::write_dataset<double>(group, "rest", mesh.rest);
  hdf5::write_dataset<int32_t>(group, "corners", mesh.corners);
  hdf5::write_dataset<double>(group, "mass", mesh.mass);
  hdf5::write_dataset<uint8_t>(group, "pinned", mesh.pinned);
  hdf5::write_dataset<int32_t>(group, "material", mesh.material);
}

void write_grid(hid_t file, const Scene& scene) {
  const hdf5::Handle group = hdf5::create_group(file, "grid");
  hdf5::write_dataset<double>(group, "rest", scene.grid.rest);
  hdf5::write_dataset<int32_t>(group, "corners", scene.grid.corners);
  hdf5::write_dataset<double>(group, "fill", scene.grid.fill);
  hdf5::write_dataset<double>(group, "shape_mean", scene.grid.shape_mean);
  hdf5::write_dataset<double>(group, "mass", scene.mass);
  hdf5::write_dataset<uint8_t>(group, "pinned", scene.pinned);
  hdf5::write_dataset<double>(group, "hourglass", scene.variance);
  hdf5::write_dataset<int32_t>(group, "material", scene.material);
}

/// A field of entries of particles beside x and v.
struct EntryField {
  const char* name;
  int cols;
};
constexpr EntryField kMotion[] = {{"x", 3}, {"v", 3}};
constexpr EntryField kStrain[] = {{"F", 9}, {"C", 9}, {"memory", 1}};

std::vector<EntryField> entry_fields(const StateHeader& header) {
  std::vector<EntryField> fields(std::begin(kMotion), std::end(kMotion));
  if (header.particles) fields.insert(fields.end(), std::begin(kStrain), std::end(kStrain));
  return fields;
}

void write_particles(hid_t group, const ParticleSet& particles) {
  hdf5::write_dataset<double>(group, "mass", particles.mass);
  hdf5::write_dataset<double>(group, "volume", particles.volume);
  hdf5::write_dataset<int32_t>(group, "material", particles.material);
}

/// Writes /grid, and after it the fields that only finite elements have.
void write_body(hid_t file, const Scene& scene, const StateHeader& header) {
  if (header.mesh) {
    write_mesh(file, *header.mesh);
  } else {
    write_grid(file, scene);
  }
  const hdf5::Handle group(H5Gopen2(file, "grid", H5P_DEFAULT), H5Gclose, "grid");
  if (!header.fixed.empty()) hdf5::write_dataset<uint8_t>(group, "fixed", header.fixed);
  if (!header.traction.empty()) hdf5::write_dataset<double>(group, "traction", header.traction);
}

/// Writes /nets: a group for each material with a net, named by the material's number.
void write_nets(hid_t file, const StateHeader& header) {
  if (header.nets.empty()) return;
  const hdf5::Handle group = hdf5::create_group(file, "nets");
  for (size_t m = 0; m < header.nets.size(); ++m) {
    const StateNet& net = header.nets[m];
    if (net.weights.empty()) continue;
    const hdf5::Handle one = hdf5::create_group(group, std::to_string(m).c_str());
    hdf5::write_attribute(one, "sha256", net.hash);
    hdf5::write_attribute(one, "cells", net.cells);
    hdf5::write_dataset<float>(one, "weights",
                               {net.weights.data(), int64_t(net.weights.size()), 1});
    if (net.cells == 0) continue;
    const auto edge = int64_t(std::lround(std::cbrt(double(net.table.size()))));
    hdf5::write_dataset<float>(one, "table", {net.table.data(), edge * edge, int(edge)});
  }
}

/// A text type of fixed length that holds the longest name.
hdf5::Handle text_type(size_t longest) {
  hdf5::Handle type(H5Tcopy(H5T_C_S1), H5Tclose, "text type");
  hdf5::check(H5Tset_size(type, longest + 1), "text type");
  hdf5::check(H5Tset_cset(type, H5T_CSET_UTF8), "text type");
  return type;
}

/// Rows of /materials in memory: name and law of `text` bytes each, then three numbers.
std::vector<char> material_rows(const std::vector<Material>& materials, size_t text) {
  const size_t row = 2 * text + 3 * sizeof(double);
  std::vector<char> rows(row * materials.size());
  for (size_t m = 0; m < materials.size(); ++m) {
    const Material& material = materials[m];
    const double numbers[3] = {material.young, material.poisson, material.density};
    char* at = rows.data() + row * m;
    std::copy(material.name.begin(), material.name.end(), at);
    const std::string law = law_name(material.law);
    std::copy(law.begin(), law.end(), at + text);
    std::memcpy(at + 2 * text, numbers, sizeof(numbers));
  }
  return rows;
}

void write_materials(hid_t file, const std::vector<Material>& materials) {
  size_t longest = 0;
  for (const Material& m : materials)
    longest = std::max({longest, m.name.size(), law_name(m.law).size()});
  const size_t text = longest + 1;
  const hdf5::Handle name = text_type(longest);
  const hdf5::Handle type(H5Tcreate(H5T_COMPOUND, 2 * text + 3 * sizeof(double)), H5Tclose,
                          "materials");
  hdf5::check(H5Tinsert(type, "name", 0, name), "materials");
  hdf5::check(H5Tinsert(type, "law", text, name), "materials");
  const char* numbers[3] = {"young", "poisson", "density"};
  for (size_t k = 0; k < 3; ++k)
    hdf5::check(H5Tinsert(type, numbers[k], 2 * text + k * sizeof(double), H5T_NATIVE_DOUBLE),
                "materials");
  const hdf5::Handle dataset = hdf5::create_dataset(file, "materials", type, {materials.size()});
  const std::vector<char> rows = material_rows(materials, text);
  hdf5::check(H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, rows.data()), "materials");
}

/// Writes the names of the colliders, dataset (colliders) of text.
void write_names(hid_t group, const std::vector<Collider>& colliders) {
  size_t longest = 0;
  for (const Collider& c : colliders) longest = std::max(longest, c.name.size());
  std::vector<char> rows((longest + 1) * colliders.size());
  for (size_t c = 0; c < colliders.size(); ++c)
    std::copy(colliders[c].name.begin(), colliders[c].name.end(), rows.data() + (longest + 1) * c);
  const hdf5::Handle type = text_type(longest);
  const hdf5::Handle dataset = hdf5::create_dataset(group, "name", type, {colliders.size()});
  hdf5::check(H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, rows.data()), "name");
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
  write_names(group, colliders);
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

/// Writes one value of each report, dataset (steps).
template <class T, class Value>
void write_column(hid_t group, const char* name, const std::vector<StepReport>& reports,
                  const Value& value) {
  Array<T> column(int64_t(reports.size()));
  for (int64_t t = 0; t < column.rows(); ++t) column(t) = static_cast<T>(value(reports[t]));
  hdf5::write_dataset<T>(group, name, column);
}

void write_reports(hid_t group, const std::vector<StepReport>& all) {
  using R = const StepReport&;
  write_column<uint8_t>(group, "scheme", all, [](R r) { return r.scheme; });
  write_column<double>(group, "residual", all, [](R r) { return r.residual; });
  write_column<uint8_t>(group, "converged", all, [](R r) { return r.converged; });
  write_column<int32_t>(group, "outer", all, [](R r) { return r.outer; });
  write_column<int32_t>(group, "inner", all, [](R r) { return r.inner; });
  write_column<double>(group, "ms", all, [](R r) { return r.ms; });
  write_column<double>(group, "energy_kinetic", all, [](R r) { return r.energy.kinetic; });
  write_column<double>(group, "energy_elastic", all, [](R r) { return r.energy.elastic; });
  write_column<double>(group, "energy_hourglass", all, [](R r) { return r.energy.hourglass; });
  write_column<double>(group, "energy_gravity", all, [](R r) { return r.energy.gravity; });
  write_column<double>(group, "energy_contact", all, [](R r) { return r.energy.contact; });
  write_column<double>(group, "min_j", all, [](R r) { return r.min_j; });
}

/// Writes the further values of steps of bodies that yield.
void write_yields(hid_t group, const std::vector<StepReport>& all) {
  using R = const StepReport&;
  write_column<double>(group, "energy_plastic", all, [](R r) { return r.energy.plastic; });
  write_column<int32_t>(group, "fallbacks", all, [](R r) { return r.fallbacks; });
}

void write_plastic(hid_t file, const StatePlastic& plastic) {
  const hdf5::Handle group = hdf5::create_group(file, "plastic");
  hdf5::write_dataset<double>(group, "yields", plastic.yields);
  if (plastic.Fp_inverse.empty()) return;
  hdf5::write_dataset<double>(group, "Fp_inverse", plastic.Fp_inverse);
  hdf5::write_dataset<double>(group, "memory", plastic.memory);
}

/// Copies the fields of each entry from the raw file.
void write_entries(hid_t group, const std::vector<EntryField>& fields, std::FILE* spill,
                   const std::string& path, int64_t entries, int64_t nodes) {
  std::vector<hdf5::Handle> datasets;
  std::vector<Array<double>> values;
  for (const EntryField& field : fields) {
    std::vector<hsize_t> extents = {hsize_t(entries), hsize_t(nodes)};
    if (field.cols > 1) extents.push_back(hsize_t(field.cols));
    datasets.push_back(hdf5::create_dataset(group, field.name, H5T_IEEE_F64LE, extents));
    values.emplace_back(nodes, field.cols);
  }
  if (std::fseek(spill, 0, SEEK_SET) != 0) fail(path, "keeping the last steps");
  for (hsize_t entry = 0; entry < hsize_t(entries); ++entry)
    for (size_t k = 0; k < fields.size(); ++k) {
      const auto size = size_t(values[k].size());
      if (std::fread(values[k].data(), sizeof(double), size, spill) != size)
        fail(path, "reading a step back");
      hdf5::write_entry(datasets[k], entry, values[k]);
    }
}

}  // namespace

StateWriter::StateWriter(const std::string& path, const Scene& scene, const StateHeader& header,
                         const State& initial, const ParticleStrain* strain)
    : scene_(scene),
      header_(header),
      path_(path),
      spill_file_(path),
      spill_(::fdopen(::dup(spill_file_.descriptor()), "w+b"), std::fclose) {
  if (!spill_) fail(path, "keeping the steps");
  keep(initial, strain);
}

int64_t StateWriter::node_count() const {
  if (header_.particles) return header_.particles->count();
  return header_.mesh ? header_.mesh->rest.rows() : scene_.grid.node_count();
}

void StateWriter::keep(const State& state, const ParticleStrain* strain) {
  const std::vector<EntryField> fields = entry_fields(header_);
  std::vector<Span<const double>> values = {state.x, state.v};
  if (strain) values.insert(values.end(), {strain->F, strain->C, strain->memory});
  ELASTOGEN_CHECK(values.size() == fields.size(), "entries need ", fields.size(), " arrays, got ",
                  values.size());
  for (size_t k = 0; k < fields.size(); ++k) {
    ELASTOGEN_CHECK(values[k].is(node_count(), fields[k].cols), fields[k].name, " must be (",
                    node_count(), ", ", fields[k].cols, "), got ", values[k]);
    const auto size = size_t(values[k].size());
    if (std::fwrite(values[k].data, sizeof(double), size, spill_.get()) != size)
      fail(path_, "keeping a step");
  }
  time_.push_back(state.time);
}

void StateWriter::step(const State& state, const StepReport& report, const ParticleStrain* strain) {
  keep(state, strain);
  reports_.push_back(report);
}

void StateWriter::finish() {
  // HDF5 may be built without threads, and scenes of a batch may end at one time
  static std::mutex one_at_a_time;
  const std::lock_guard lock(one_at_a_time);
  const auto entries = int64_t(time_.size());
  SafeFile safe(path_);
  hdf5::Handle file = hdf5::create_file(safe.descriptor(), path_);
  write_root(file, scene_, header_);
  if (header_.particles) {
    const hdf5::Handle particles = hdf5::create_group(file, "particles");
    write_particles(particles, *header_.particles);
    write_entries(particles, entry_fields(header_), spill_.get(), path_, entries, node_count());
  } else {
    write_body(file, scene_, header_);
  }
  write_materials(file, scene_.materials);
  write_nets(file, header_);
  write_contact(file, scene_, header_, time_);
  if (plastic_) write_plastic(file, *plastic_);
  {
    const hdf5::Handle steps = hdf5::create_group(file, "steps");
    hdf5::write_dataset<double>(steps, "time", {time_.data(), entries, 1});
    if (!header_.particles)
      write_entries(steps, entry_fields(header_), spill_.get(), path_, entries, node_count());
    write_reports(steps, reports_);
    if (plastic_ && !header_.particles) write_yields(steps, reports_);
  }
  file.close();
  safe.commit();
}

}  // namespace elastogen
