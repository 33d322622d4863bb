// SPDX-License-Identifier: Apache-2.0
#include "cli/particle_study.hpp"
#include "io/safe_file.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace elastogen {
namespace {

using Json = nlohmann::ordered_json;

struct Column {
  const char* name;
  double mpm::Likeness::*value;
};
constexpr Column kLikeness[] = {{"iou_w", &mpm::Likeness::iou_weighted},
                                {"iou_b", &mpm::Likeness::iou_binary},
                                {"iou_soft", &mpm::Likeness::iou_soft},
                                {"iou_soft_scaled", &mpm::Likeness::iou_soft_scaled}};

/// Half the extent along x and z, and the top along y [m].
Vec3 extents(const CloudReport& cloud) {
  return {(cloud.upper[0] - cloud.lower[0]) / 2, cloud.upper[1],
          (cloud.upper[2] - cloud.lower[2]) / 2};
}

double a_step(const ParticleRun& run, int64_t count) {
  return run.steps > 0 ? double(count) / double(run.steps) : 0;
}

/// The first run of an integrator with a transfer after each step; null if there is none.
const ParticleRun* first_of(const ParticleStudyResult& result, Integrator kind) {
  for (const ParticleRun& run : result.runs)
    if (run.options.integrator == kind && run.options.substeps == 1) return &run;
  return nullptr;
}

Json ranges(const ParticleRun& run, mpm::Likeness ParticleFrame::*reference) {
  Json json;
  for (const Column& column : kLikeness) {
    const LikenessRange range = range_of(run, reference, column.value);
    json[column.name] = {{"worst", range.worst}, {"mean", range.mean}};
  }
  return json;
}

Json likeness(const mpm::Likeness& of) {
  Json json;
  for (const Column& column : kLikeness) json[column.name] = of.*column.value;
  return json;
}

Json to_json(const ParticleFrame& f) {
  return {{"time", f.time},
          {"half_width", extents(f.cloud)[0]},
          {"half_depth", extents(f.cloud)[2]},
          {"top", extents(f.cloud)[1]},
          {"volume", f.cloud.volume},
          {"kinetic", f.kinetic},
          {"elastic", f.elastic},
          {"solves", f.solves},
          {"iterations", f.iterations},
          {"not_converged", f.not_converged},
          {"residual", f.residual},
          {"to_sub", likeness(f.to_sub)},
          {"to_explicit", likeness(f.to_explicit)}};
}

Json to_json(const ParticleRun& run) {
  Json frames = Json::array();
  for (const ParticleFrame& frame : run.frames) frames.push_back(to_json(frame));
  return {{"name", run.name},
          {"integrator", integrator_name(run.options.integrator)},
          {"dt", run.options.dt},
          {"substeps", run.options.substeps},
          {"steps", run.steps},
          {"step_seconds", run.step_seconds},
          {"solves_a_step", a_step(run, run.solves)},
          {"iterations_a_step", a_step(run, run.iterations)},
          {"factored_a_step", a_step(run, run.factored)},
          {"not_converged", run.not_converged},
          {"worst_residual", run.worst_residual},
          {"broke_off", run.broke_off},
          {"to_sub", ranges(run, &ParticleFrame::to_sub)},
          {"to_explicit", ranges(run, &ParticleFrame::to_explicit)},
          {"frames", frames}};
}

Json to_json(const ParticleStudyResult& r) {
  // runs, and how many explicit steps cost as much as an implicit one
  Json runs = Json::array();
  for (const ParticleRun& run : r.runs) runs.push_back(to_json(run));
  const ParticleRun* implicit = first_of(r, Integrator::kImplicit);
  const ParticleRun* plain = r.find(r.explicit_reference);
  Json equivalents;  // null unless both runs exist
  if (implicit && plain && plain->step_seconds > 0)
    equivalents = implicit->step_seconds / plain->step_seconds;
  // the study itself
  return {{"format", "elastogen-particle-study"},
          {"version", 1},
          {"scene", r.scene},
          {"command", r.command},
          {"commit", r.commit},
          {"date", r.date},
          {"cpu", r.cpu},
          {"threads", r.threads},
          {"dimension", r.dimension},
          {"particles", r.particles},
          {"h", r.h},
          {"crossing_time", r.crossing},
          {"transfer", r.transfer},
          {"sub_reference", r.sub_reference},
          {"explicit_reference", r.explicit_reference},
          {"explicit_steps_an_implicit_step", equivalents},
          {"runs", runs}};
}

/// A line of heads, then a line for each run and frame.
std::string csv(const ParticleStudyResult& r) {
  std::string text =
      "run,time [s],half_width [m],half_depth [m],top [m],volume [m3],kinetic [J],elastic [J],"
      "solves [1],iterations [1],not_converged [1],residual [-]";
  for (const char* reference : {"to_sub", "to_explicit"})
    for (const Column& column : kLikeness)
      text += fmt::format(",{}.{} [-]", reference, column.name);
  for (const ParticleRun& run : r.runs)
    for (const ParticleFrame& f : run.frames) {
      const Vec3 size = extents(f.cloud);
      text += fmt::format("\n{},{},{},{},{},{},{},{},{},{},{},{}", run.name, f.time, size[0],
                          size[2], size[1], f.cloud.volume, f.kinetic, f.elastic, f.solves,
                          f.iterations, f.not_converged, f.residual);
      for (const mpm::Likeness& of : {f.to_sub, f.to_explicit})
        for (const Column& column : kLikeness) text += fmt::format(",{}", of.*column.value);
    }
  return text + '\n';
}

}  // namespace

void write_particle_study(const std::string& folder, const ParticleStudyResult& result) {
  write_file(folder + "/particles.json",
             to_json(result).dump(1, ' ', false, Json::error_handler_t::replace) + '\n');
  write_file(folder + "/particles.csv", csv(result));
}

void print_particle_study(const ParticleStudyResult& result) {
  fmt::print("{} particles, {} {}; likeness to {}\n", result.particles, result.transfer,
             result.dimension == 2 ? "in the plane" : "in space", result.sub_reference);
  for (const ParticleRun& run : result.runs) {
    const Vec3 size = extents(run.frames.back().cloud);
    fmt::print("{:26} {:9.3g} s a step, {:.1f} solves, {:.1f} iterations, {} of {} not converged\n",
               run.name, run.step_seconds, a_step(run, run.solves), a_step(run, run.iterations),
               run.not_converged, run.steps);
    fmt::print("{:26} half width {:.3f} m, top {:.3f} m", "", size[0], size[1]);
    for (const Column& column : kLikeness) {
      const LikenessRange range = range_of(run, &ParticleFrame::to_sub, column.value);
      fmt::print("  {} {:.3f} / {:.3f}", column.name, range.worst, range.mean);
    }
    fmt::print("{}\n", run.broke_off ? "  (broke off)" : "");
  }
  const ParticleRun* implicit = first_of(result, Integrator::kImplicit);
  const ParticleRun* plain = result.find(result.explicit_reference);
  if (implicit && plain && plain->step_seconds > 0)
    fmt::print("an implicit step takes the time of {:.0f} explicit ones\n",
               implicit->step_seconds / plain->step_seconds);
}

}  // namespace elastogen
