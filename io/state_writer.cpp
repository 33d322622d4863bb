// SPDX-License-Identifier: Apache-2.0
#include "io/state_writer.hpp"

#include "core/constants.hpp"
#include "core/error.hpp"
#include "core/scene.hpp"
#include "core/step_verdict.hpp"
#include "core/time_scheme.hpp"
#include "io/hdf5_file.hpp"
#include "io/safe_file.hpp"
#include "io/state_holders.hpp"
#include "io/state_loads.hpp"
#include "io/state_parts.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <limits>
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

/// Whether the steps of a run are made by stages.
bool makes_stages(const Scene& scene, const StateHeader& header) {
  return has_stages(scene.scheme) && header.scheme.empty() && !header.particles;
}

void write_root(hid_t file, const Scene& scene, const StateHeader& header) {
  const double gravity[3] = {scene.gravity[0], scene.gravity[1], scene.gravity[2]};
  const double place[3] = {scene.place[0], scene.place[1], scene.place[2]};
  hdf5::write_attribute(file, "format", std::string("elastogen-state"));
  hdf5::write_attribute(file, "version", 5);
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
  if (makes_stages(scene, header)) hdf5::write_attribute(file, "moved", int(header.moved));
}

void write_mesh(hid_t file, const StateMesh& mesh) {
  const hdf5::Handle group = hdf5::create_group(file, "grid");
  hdf5::write_dataset<double>(group, "rest", mesh.nodes.grid.rest);
  hdf5::write_dataset<int32_t>(group, "corners", mesh.corners);
  hdf5::write_dataset<double>(group, "mass", mesh.mass);
  hdf5::write_dataset<uint8_t>(group, "pinned", mesh.nodes.pinned);
  hdf5::write_dataset<int32_t>(group, "material", mesh.material);
  if (mesh.part.empty()) return;
  hdf5::write_dataset<double>(group, "fill", mesh.fill);
  hdf5::write_dataset<double>(group, "part", mesh.part);
  write_dependent(group, mesh.nodes.dependent);
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
  if (!scene.dependent.empty()) write_dependent(group, scene.dependent);
}

/// What the raw file has of each entry: a dataset (entries, extents).
struct EntryField {
  const char *group, *name;
  std::vector<int64_t> extents;
  bool from_start = true;  // the start is an entry too

  int64_t size() const {
    int64_t product = 1;
    for (const int64_t extent : extents) product *= extent;
    return product;
  }
};

/// In the order of the raw file.
std::vector<EntryField> entry_fields(const Scene& scene, const StateHeader& header) {
  if (header.particles) {
    const char* group = "particles";
    const int64_t count = header.particles->count();
    return {{group, "x", {count, 3}},
            {group, "v", {count, 3}},
            {group, "F", {count, 9}},
            {group, "C", {count, 9}},
            {group, "memory", {count}}};
  }
  const int64_t nodes = header.mesh ? header.mesh->nodes.grid.rest.rows() : scene.grid.node_count();
  std::vector<EntryField> fields = {{"steps", "x", {nodes, 3}}, {"steps", "v", {nodes, 3}}};
  if (has_changing_loads(scene, header)) fields.push_back({"steps", "load", {nodes, 3}, false});
  if (!makes_stages(scene, header)) return fields;
  if (has_changing_loads(scene, header))
    fields.push_back({"steps", "load_stage", {nodes, 3}, false});
  fields.push_back({"steps", "x_stage", {nodes, 3}, false});
  const int64_t points =
      header.mesh ? header.mesh->contact_nodes.rows() : scene.surface.voxel.rows();
  if (!scene.colliders.empty())
    fields.push_back({"contact", "bonds", {int64_t(scene.colliders.size()), points, 3}});
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

/// Writes one value of each report, dataset (steps).
template <class T, class Value>
void write_column(hid_t group, const char* name, const std::vector<ReportFields>& reports,
                  const Value& value) {
  Array<T> column(int64_t(reports.size()));
  for (int64_t t = 0; t < column.rows(); ++t) column(t) = static_cast<T>(value(reports[t]));
  hdf5::write_dataset<T>(group, name, column);
}

void write_reports(hid_t group, const std::vector<ReportFields>& all) {
  using R = const ReportFields&;
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

/// Writes what tells the potential of a step.
void write_lengths(hid_t group, const Scene& scene, const StateHeader& header,
                   const std::vector<ReportFields>& all) {
  using R = const ReportFields&;
  write_column<double>(group, "length", all,
                       [&](R r) { return r.length > 0 ? r.length : scene.dt; });
  write_column<double>(group, "tolerance", all,
                       [&](R r) { return r.tolerance > 0 ? r.tolerance : header.tolerance; });
  if (!makes_stages(scene, header)) return;
  write_column<uint8_t>(group, "guarded", all, [](R r) { return r.guarded; });
  write_column<double>(group, "time_error", all, [](R r) { return r.time_error; });
  write_column<double>(group, "time_ratio", all, [](R r) { return r.time_ratio; });
}

/// Writes the mesh numbers of a run that has some; NaN at steps without one.
void write_mesh_errors(hid_t group, const std::vector<ReportFields>& all) {
  using R = const ReportFields&;
  if (std::ranges::none_of(all, [](R r) { return r.mesh_error.has_value(); })) return;
  MeshError none{.rms = std::numeric_limits<double>::quiet_NaN(), .trusted = false};
  none.largest = none.rms;
  const auto of = [&](R r) { return r.mesh_error.value_or(none); };
  write_column<double>(group, "mesh_error", all, [&](R r) { return of(r).rms; });
  write_column<double>(group, "mesh_error_largest", all, [&](R r) { return of(r).largest; });
  write_column<uint8_t>(group, "mesh_error_trusted", all, [&](R r) { return of(r).trusted; });
}

/// Writes the further values of steps of bodies that yield.
void write_yields(hid_t group, const std::vector<ReportFields>& all) {
  using R = const ReportFields&;
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
void write_entries(hid_t file, const std::vector<EntryField>& fields, std::FILE* spill,
                   const std::string& path, int64_t entries) {
  std::vector<hdf5::Handle> datasets;
  std::vector<Array<double>> values;
  for (const EntryField& field : fields) {
    const hdf5::Handle group(H5Gopen2(file, field.group, H5P_DEFAULT), H5Gclose, field.group);
    std::vector<hsize_t> extents = {hsize_t(field.from_start ? entries : entries - 1)};
    extents.insert(extents.end(), field.extents.begin(), field.extents.end());
    datasets.push_back(hdf5::create_dataset(group, field.name, H5T_IEEE_F64LE, extents));
    values.emplace_back(field.size());
  }
  if (std::fseek(spill, 0, SEEK_SET) != 0) fail(path, "keeping the last steps");
  for (hsize_t entry = 0; entry < hsize_t(entries); ++entry)
    for (size_t k = 0; k < fields.size(); ++k) {
      if (entry == 0 && !fields[k].from_start) continue;
      const auto size = size_t(values[k].size());
      if (std::fread(values[k].data(), sizeof(double), size, spill) != size)
        fail(path, "reading a step back");
      hdf5::write_entry(datasets[k], fields[k].from_start ? entry : entry - 1, values[k]);
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
  keep(initial, strain, nullptr, {});
}

void StateWriter::keep(const State& state, const ParticleStrain* strain, const StepReport* report,
                       const StageData& data) {
  const std::vector<EntryField> fields = entry_fields(scene_, header_);
  std::vector<Span<const double>> values = {state.x, state.v};
  if (strain) values.insert(values.end(), {strain->F, strain->C, strain->memory});
  // steps of one stage have no first one, and before the first step no bond holds
  Array<double> none, free;
  none = Array<double>(state.x.rows(), 3);
  none.fill(std::numeric_limits<double>::quiet_NaN());
  const bool stages = makes_stages(scene_, header_), loaded = has_changing_loads(scene_, header_);
  const bool has_first = report && report->scheme == TimeScheme::kSdirk2;
  if (loaded) values.push_back(report ? data.load : Span<const double>(none));
  if (loaded && stages) values.push_back(has_first ? data.first_load : Span<const double>(none));
  if (stages) values.push_back(has_first ? data.first : Span<const double>(none));
  if (fields.size() > values.size() && stages) {
    free = Array<double>(fields.back().size());
    values.push_back(data.bonds.size() > 0 ? data.bonds : Span<const double>(free));
  }
  ELASTOGEN_CHECK(values.size() == fields.size(), "entries need ", fields.size(), " arrays, got ",
                  values.size());
  for (size_t k = 0; k < fields.size(); ++k) {
    const EntryField& field = fields[k];
    if (!report && !field.from_start) continue;
    ELASTOGEN_CHECK(values[k].size() == field.size(), field.name, " must have ", field.size(),
                    " numbers, got ", values[k]);
    const auto size = size_t(values[k].size());
    if (std::fwrite(values[k].data, sizeof(double), size, spill_.get()) != size)
      fail(path_, "keeping a step");
  }
  time_.push_back(state.time);
}

void StateWriter::step(const State& state, const StepReport& report, const ParticleStrain* strain,
                       const StageData& data) {
  keep(state, strain, &report, data);
  reports_.push_back({report.scheme, is_converged(report), report.guarded, report.outer,
                      report.inner, report.fallbacks, report.residual, report.ms, report.min_j,
                      report.length, report.tolerance, report.time_error, report.time_ratio,
                      report.energy, report.mesh_error});
  reactions_.insert(reactions_.end(), report.reactions.begin(), report.reactions.end());
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
  } else {
    write_body(file, scene_, header_);
  }
  write_materials(file, scene_.materials);
  write_nets(file, header_);
  write_contact(file, scene_, header_, time_);
  if (!header_.particles) write_holders(file, scene_, header_, time_);
  if (!header_.particles) write_loads(file, scene_, header_, time_);
  if (plastic_) write_plastic(file, *plastic_);
  {
    const hdf5::Handle steps = hdf5::create_group(file, "steps");
    hdf5::write_dataset<double>(steps, "time", {time_.data(), entries, 1});
    write_reports(steps, reports_);
    if (!header_.particles) write_lengths(steps, scene_, header_, reports_);
    write_mesh_errors(steps, reports_);
    write_reactions(steps, scene_.holders.size(), reactions_);
    if (plastic_ && !header_.particles) write_yields(steps, reports_);
  }
  write_entries(file, entry_fields(scene_, header_), spill_.get(), path_, entries);
  file.close();
  safe.commit();
}

}  // namespace elastogen
