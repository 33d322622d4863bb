// SPDX-License-Identifier: Apache-2.0
#include "cli/run.hpp"

#include "cli/ledger_lines.hpp"
#include "cli/picture/picture_writer.hpp"
#include "cli/progress.hpp"
#include "cli/signals.hpp"
#include "cli/weights.hpp"
#include "core/error.hpp"
#include "core/parallel.hpp"
#include "core/time_scheme.hpp"
#include "io/safe_file.hpp"
#include "mpm_fem/materials/solid_presets.hpp"
#include "scene/particle_integrator.hpp"
#include "scene/particle_setup.hpp"
#include "scene/particle_stepper.hpp"
#include "scene/version.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace elastogen {
namespace {

/// Prints a line for each material that is damped. False where none is.
bool print_loss_factors(const Scene& scene) {
  bool any = false;
  for (const Material& m : scene.materials) {
    const double loss = m.loss_factor.value_or(0);
    if (!(loss > 0)) continue;
    fmt::print(
        "damping of {}: loss factor {:.3g} at {:.3g} Hz (a vibration keeps {:.0f} % of its "
        "amplitude a period), in proportion to frequency\n",
        m.name, loss, m.loss_frequency, 100 * std::exp(-std::numbers::pi * loss));
    any = true;
  }
  return any;
}

/// Prints the numerical damping; for particles that of Euler's scheme alone, not of transfers.
void print_damping(const Setup& setup, const ParticleOptions& options) {
  const bool parts = setup.particles.has_value();
  if (print_loss_factors(setup.scene) || has_stages(setup.scene.scheme)) return;
  if (parts && options.integrator == Integrator::kExplicit) return;
  double dt = setup.scene.dt;
  if (parts) dt = options.dt > 0 ? std::min(options.dt, dt) : longest_part(dt);
  const TimeScheme scheme = parts ? TimeScheme::kEuler : setup.scene.scheme;
  if (parts)
    fmt::print("numerical damping in parts of {:.4g} s at most, beside that of the grid:", dt);
  else
    fmt::print("numerical damping:");
  fmt::print(" a vibration of 1 / 5 / 20 Hz keeps");
  for (const double f : {1.0, 5.0, 20.0})
    fmt::print("{} {:.0f} %", f == 1 ? "" : " /",
               100 * amplitude_kept(scheme, 2 * std::numbers::pi * f * dt));
  fmt::print(" of its amplitude a period\n");
}

void print_particles(const Setup& setup, const ParticleOptions& options) {
  const ParticleSetup& p = *setup.particles;
  const bool implicit = options.integrator != Integrator::kExplicit;
  fmt::print("{} particles{} on a grid of {:.4g} m, {} steps", p.particles.count(),
             p.dimension == 2 ? " in the plane" : "", setup.scene.grid.h,
             integrator_name(options.integrator));
  const double dt = implicit ? options.dt : explicit_dt(mpm_scene(setup, options), options);
  if (dt > 0) fmt::print(", {:.4g} s from transfer to transfer", dt);
  if (!implicit) fmt::print(" in {} part{}", options.substeps, options.substeps == 1 ? "" : "s");
  fmt::print("\n");
}

/// A line for each material: its law, or how it yields, and its moduli.
void print_materials(const Setup& setup) {
  for (size_t k = 0; k < setup.scene.materials.size(); ++k) {
    const Material& m = setup.scene.materials[k];
    const bool yields = !setup.yields.empty() && setup.yields[k].index() > 0;
    fmt::print("{}: {}, E {:.4g} Pa, nu {:.4g}, rho {:.4g} kg/m^3\n", m.name,
               yields ? yield_name(setup.yields[k]) : law_name(m.law), m.young, m.poisson,
               m.density);
  }
}

/// Prints how frames are divided into steps.
void print_steps(const Setup& setup, const AnimateOptions& o) {
  const Scene& scene = setup.scene;
  if (scene.scheme == TimeScheme::kAuto)
    fmt::print(
        "{} frames at {:.4g} fps, steps for a time error of {:.3g} %, Courant number of a "
        "frame {:.3g}\n",
        o.frames, o.fps, 100 * o.solver.time_error, courant_number(scene));
  else
    fmt::print("{} frames at {:.4g} fps, {} step{} a frame of {:.4g} s, Courant number {:.3g}\n",
               o.frames, o.fps, setup.substeps, setup.substeps == 1 ? "" : "s", scene.dt,
               courant_number(scene));
}

/// Prints in a few lines what will be computed: size, up, grid, material, time step, damping.
void print_setup(const Setup& setup, const AnimateOptions& o) {
  const Scene& scene = setup.scene;
  // body and grid
  fmt::print("longest edge {:.4g} m ({}), {} up ({})\n", setup.asset.size.longest_edge,
             setup.asset.size.from.reason, up_name(setup.asset.up.up), setup.asset.up.from.reason);
  if (setup.tets)
    fmt::print("{} {} ({}) of {:.4g} m, {} nodes\n", setup.tets->elements.rows(),
               fem::is_plane(setup.tets->element) ? "triangles" : "tetrahedra",
               fem::element_name(setup.tets->element), scene.grid.h, scene.grid.node_count());
  else if (scene.grid.voxel_count() > 0)
    fmt::print("{} voxels of {:.4g} m, {} nodes, {} piece{}\n", scene.grid.voxel_count(),
               scene.grid.h, scene.grid.node_count(), scene.grid.pieces,
               scene.grid.pieces == 1 ? "" : "s");
  if (setup.particles) print_particles(setup, o.particles);
  // materials and sheets
  print_materials(setup);
  if (setup.sheet_volume > 0)
    fmt::print("{} of {:.4g} m ({}), {:.4g} kg\n", setup.body.shell > 0 ? "shell" : "sheets",
               setup.sheet_thickness,
               setup.sheet_thickness == o.thickness ? "--thickness"
               : setup.body.shell > 0               ? "by its points; --thickness sets it"
                                                    : "a voxel; --thickness sets it",
               scene.materials[0].density * setup.sheet_volume);
  // time steps, if there are any
  if (o.fem && o.fem->statics) {
    fmt::print("static equilibrium\n");
    std::fflush(stdout);
    return;
  }
  print_steps(setup, o);
  print_damping(setup, o.particles);
  std::fflush(stdout);
}

void print_mesh_error(const RunMeshError& e) {
  fmt::print(
      "mesh error of the shape: {:.2g} m rms, {:.2g} m at most (estimates), where the largest "
      "motion is {:.2g} m\n",
      e.rms, e.largest, e.largest_motion);
  if (e.untrusted > 0)
    fmt::print(
        "mesh error not to be trusted in {} of {} frames: voxels of twice the edge are too "
        "coarse for it\n",
        e.untrusted, e.frames);
}

/// @param time_error  what was asked for
void print_summary(const RunReport& r, double time_error) {
  // the certificate: solve, time, mesh; then the ledger
  fmt::print("{}, worst residual {:.2e}, min J {:.3f}\n", step_counts(r), r.worst_residual,
             r.min_j);
  if (r.loosest_tolerance > SolverOptions{}.tolerance)
    fmt::print(
        "short steps were solved to a hundredth of their time error, to a residual of {:.2g} "
        "at most\n",
        r.loosest_tolerance);
  if (r.time_error > 0)
    fmt::print(
        "time error: {:.2g} m in all, {:.2g} m in a frame at most (estimates); {:.2f} "
        "solves a frame, {} of {} steps made again\n",
        r.time_error, r.largest_time_error,
        double(r.solves) / double(std::max<int64_t>(r.frames, 1)), r.rejected_steps, r.steps);
  if (r.frames_over > 0)
    fmt::print(
        "time error: {} of {} frames missed {:.3g} % of their motion at the most steps; these "
        "steps are drafts (--strict-time: exit code 4)\n",
        r.frames_over, r.frames, 100 * time_error);
  if (r.mesh_error.frames > 0) print_mesh_error(r.mesh_error);
  fmt::print("{}", ledger_lines(r.ledger));
  fmt::print("{:.1f} ms a step (median), {:.2f} s in all\n", quantile(r.step_ms, 0.5),
             r.stage_seconds.read + r.stage_seconds.voxelize + r.stage_seconds.setup +
                 r.stage_seconds.steps + r.stage_seconds.write);
}

void warn(const std::vector<std::string>& warnings, const RunHooks& hooks) {
  for (const std::string& w : warnings)
    if (hooks.on_warning)
      hooks.on_warning(w);
    else
      fmt::print(stderr, "warning: {}\n", w);
}

/// Prints the findings before the first step. @throws Error (usage) with --strict on a warning.
void say_findings(const RunReport& report, const AnimateOptions& options, const RunHooks& hooks) {
  const std::vector<Finding>& findings = report.asset.findings;
  if (!options.quiet)
    for (const std::string& line : finding_lines(findings, Severity::kNote))
      fmt::print("note: {}\n", line);
  std::vector<std::string> warnings = finding_lines(findings, Severity::kWarning);
  warnings.insert(warnings.end(), report.warnings.begin(), report.warnings.end());
  warn(warnings, hooks);
  ELASTOGEN_CHECK(!options.strict || warnings.empty(), "--strict: ", warnings[0]);
}

/// The exit code for the end of a clip.
ExitCode code_of(ClipEnd end) {
  switch (end) {
    case ClipEnd::kConverged:
      return kExitDone;
    case ClipEnd::kDraft:
      return kExitDraft;
    case ClipEnd::kDiverged:
      return kExitDiverged;
    case ClipEnd::kStopped:
      return ExitCode(128 + pending_signal());
  }
  return kExitDone;
}

/// Plays the clip with the parts that the command adds: signals, fitted nets, pictures, progress.
ClipEnd play(const Asset& asset, const Setup& setup, const AnimateOptions& options,
             const RunHooks& hooks, RunReport& report) {
  std::optional<Progress> progress(std::in_place, options.frames, options.quiet);
  bool begun = false;
  // signals, nets, and the hooks of the verb
  ClipHooks clip;
  clip.stop = [] { return pending_signal() != 0; };
  clip.make_net = make_net;
  clip.on_frame = hooks.on_frame;
  clip.on_step = hooks.on_step;
  // pictures have a writer of their own
  clip.open_writer = [&](const std::string& path, const Asset& of, const Setup& with,
                         const auto& note) -> std::unique_ptr<AnimationWriter> {
    if (ending_of(path) != "png") return nullptr;
    std::vector<std::string> notes;
    auto writer = make_picture_writer(path, of, with, options.fps, options.picture, notes);
    for (std::string& text : notes) note(std::move(text));
    return writer;
  };
  // progress, until the clip is over
  clip.on_progress = [&](int64_t frame, const FrameCertificate& c) {
    begun = true;
    progress->update(frame, c.residual, c.converged);
  };
  clip.on_note = [&](const std::string& text) {
    if (begun) progress.reset();  // the clip is over: removes the progress line
    if (!options.quiet) fmt::print("{}\n", text);
  };
  return play_clip(asset, setup, options, clip, report);
}

}  // namespace

std::string step_counts(const RunReport& r) {
  const auto count = [&](double share) { return std::llround(share * double(r.steps)); };
  std::string text = fmt::format("{} of {} steps solved", count(r.solved_share), r.steps);
  if (r.converged_share < r.solved_share)
    text += fmt::format(", {} of them within the time error", count(r.converged_share));
  return text;
}

CommandResult run_animation(const Asset& asset, const AnimateOptions& options, double read_seconds,
                            const RunHooks& hooks) {
  // settings and header of the report
  std::optional<ThreadLimit> threads;
  if (options.threads > 0) threads.emplace(options.threads);
  CommandResult result;
  RunReport& report = result.report;
  report.command = options.command;
  report.commit = build_commit();
  report.stage_seconds.read = read_seconds;

  // set up, and print what was found
  const Setup setup = hooks.tets ? set_up(*hooks.tets, options) : set_up(asset, options);
  add_summary(setup, report);
  if (!options.quiet) print_setup(setup, options);
  say_findings(report, options, hooks);
  const size_t warned = report.warnings.size();

  // play and report
  if (!options.report.empty()) SafeFile probe(options.report);  // throws early if unwritable
  result.code = code_of(play(shown_asset(asset, setup), setup, options, hooks, report));
  report.peak_memory_bytes = peak_memory_bytes();
  if (!options.report.empty()) write_report(options.report, report);
  // warnings of the clip
  warn({report.warnings.begin() + int64_t(warned), report.warnings.end()}, hooks);
  if (options.strict && report.warnings.size() > warned && result.code == kExitDone)
    result.code = kExitUsage;
  if (options.strict_time && report.frames_over > 0 && result.code == kExitDone)
    result.code = kExitDraft;
  if (!options.quiet) print_summary(report, options.solver.time_error);
  return result;
}

}  // namespace elastogen
