// SPDX-License-Identifier: Apache-2.0
#include "cli/study_runs.hpp"

#include "cli/signals.hpp"
#include "cli/study_machine.hpp"
#include "cli/weights.hpp"
#include "core/error.hpp"
#include "io/animation_writer.hpp"
#include "scene/asset_stages.hpp"
#include "scene/version.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace elastogen {
namespace {

constexpr double kReferenceTolerance = 1e-9;  // tolerance of the residual in finite element runs

/// Mean wall time of a step.
double step_ms(const Trajectory& run) {
  double sum = 0;
  for (const StepReport& r : run.reports) sum += r.ms;
  return run.reports.empty() ? 0 : sum / double(run.reports.size());
}

StepTime quartiles(const std::vector<double>& ms) {
  return {quantile(ms, 0.25), quantile(ms, 0.5), quantile(ms, 0.75)};
}

}  // namespace

Study::Study(const StudyTask& task) : task_(task), asset_(run_asset(task.scene)) {
  stage_ = make_stage(task.scene);
}

StudyStage Study::make_stage(const AnimateOptions& options) const {
  StudyStage stage{set_up(asset_, options), 0};
  stage.steps = options.frames * stage.setup.substeps;
  return stage;
}

AnimateOptions Study::fem_options(fem::Element element) const {
  AnimateOptions o = task_.scene;
  o.fem = FemOptions{.element = element, .mass = fem::Mass::kLumped, .newmark = false};
  o.solver.tolerance = kReferenceTolerance;
  return o;
}

AnimateOptions Study::network_options(SolverMode mode, double tolerance) const {
  AnimateOptions o = task_.scene;
  o.solver.mode = mode;
  o.solver.tolerance = tolerance;
  return o;
}

void Study::take_energies(const Trajectory& trajectory, StudyRun& run) const {
  for (const StepReport& r : trajectory.reports) {
    const EnergyParts& e = r.energy;
    run.residual.push_back(r.residual);
    run.energy.kinetic.push_back(e.kinetic);
    run.energy.elastic.push_back(e.elastic);
    run.energy.hourglass.push_back(e.hourglass);
    run.energy.gravity.push_back(e.gravity);
    run.energy.contact.push_back(e.contact);
    run.energy.total.push_back(e.kinetic + e.elastic + e.hourglass + e.gravity + e.contact);
    run.outer += r.outer;
    run.inner += r.inner;
    run.converged_share += r.converged;
    run.worst_residual = std::max(run.worst_residual, r.residual);
    run.min_j = std::min(run.min_j, r.min_j);
  }
  run.steps = int64_t(trajectory.reports.size());
  if (run.steps > 0) run.converged_share /= double(run.steps);
}

/// Runs the scene of a stage and times it, after one run to warm up if it is repeated. Finite
/// elements run once: they need minutes, and nobody chooses them for their speed.
namespace {

/// Solver, element and size of a run.
void describe(const Stepper& stepper, const Scene& scene, StudyRun& run) {
  StateHeader header;
  stepper.describe(header);
  run.solver = header.solver;
  run.element = header.element;
  run.h = scene.grid.h;
  run.dt = scene.dt;
  run.voxels = scene.grid.voxel_count();
  run.elements = header.mesh ? header.mesh->corners.rows() : run.voxels;
  const Array<uint8_t>& pinned = header.mesh ? header.mesh->nodes.pinned : scene.pinned;
  run.dofs = 3 * std::count(pinned.data(), pinned.data() + pinned.size(), uint8_t(0));
}

}  // namespace

StudyRun& Study::add_run(const std::string& name, const StudyStage& stage,
                         const AnimateOptions& options, Trajectory* kept) {
  if (!options.quiet) fmt::print("{} ...\n", name);
  std::fflush(stdout);
  std::vector<std::string> notes;  // stays empty, as energy is never auto here
  const std::unique_ptr<Stepper> stepper =
      make_stepper(stage.setup, options, {[] { return pending_signal() != 0; }, make_net}, notes);
  // several runs are timed; the first is not
  Trajectory trajectory;
  std::vector<double> ms;
  const int repeats = options.fem ? 1 : task_.repeats;
  for (int k = repeats > 1 ? -1 : 0; k < repeats; ++k) {
    trajectory = free_run(*stepper, options.motion, stage.steps);
    if (k >= 0) ms.push_back(step_ms(trajectory));
    if (pending_signal() != 0) throw StudyInterrupted();
  }
  StudyRun& run = result_.runs.emplace_back();
  run.name = name;
  describe(*stepper, stage.setup.scene, run);
  run.step_ms = quartiles(ms);
  run.state_bytes = 2 * int64_t(sizeof(double)) * trajectory.states[0].x.size();
  run.state_copies_per_second = copies_per_second(run.state_bytes);
  const bool paper = !options.fem && options.solver.mode == SolverMode::kPaper;
  const PaperLoops& loops = options.solver.paper;
  if (paper) run.loops = LoopBudget{loops.outer, loops.inner, loops.modes};
  if (!paper) run.tolerance = options.solver.tolerance;
  take_energies(trajectory, run);
  if (kept) *kept = std::move(trajectory);
  return run;
}

StudyErrors Study::solver_errors(const StudyStage& stage, const AnimateOptions& options,
                                 const Trajectory& run, const Reference& reference) const {
  const Scene& scene = stage.setup.scene;
  const Body& body = stage.setup.body;
  std::vector<std::string> notes;
  const std::unique_ptr<Stepper> stepper =
      make_stepper(stage.setup, options, {.make_net = make_net}, notes);
  StudyErrors errors;
  errors.reference = reference.name;
  errors.step = step_errors(*stepper, scene, reference.run);
  errors.free_run = free_run_errors(scene, run, reference.run);
  errors.iou = shape_iou(body.surface, surface_at(body, scene, run.states.back()),
                         surface_at(body, scene, reference.run.states.back()), scene.grid.h);
  errors.energy_drift = energy_drift(run, reference.run);
  return errors;
}

StudyErrors Study::grid_errors(const StudyStage& stage, const Trajectory& run) const {
  const Scene &scene = stage.setup.scene, &fine = fine_->setup.scene;
  StudyErrors errors;
  errors.reference = grid_reference_.name;
  errors.free_run = errors_between(scene, run, fine, grid_reference_.run);
  errors.iou = shape_iou(
      stage.setup.body.surface, surface_at(stage.setup.body, scene, run.states.back()),
      surface_at(fine_->setup.body, fine, grid_reference_.run.states.back()), fine.grid.h);
  errors.energy_drift = energy_drift(run, grid_reference_.run);
  errors.reference_change = reference_change_;
  return errors;
}

/// Adds the last frame, cut through the middle of the body along its two longest axes.
void Study::add_overlay(const std::string& name, const StudyStage& stage, const Trajectory& run) {
  const Surface& surface = stage.setup.body.surface;
  int across = 0;
  for (int d = 1; d < 3; ++d)
    if (surface.box.extent(d) < surface.box.extent(across)) across = d;
  const double place = (surface.box.lower[size_t(across)] + surface.box.upper[size_t(across)]) / 2;
  if (result_.overlays.empty()) {
    const char* axes = "xyz";
    ShapeOverlay& overlay = result_.overlays.emplace_back();
    overlay.title = fmt::format("section {} = {:.3g} m", axes[across], place);
    overlay.time = run.states.back().time;
    overlay.horizontal = axes[across == 0 ? 1 : 0];
    overlay.vertical = axes[across == 2 ? 1 : 2];
    overlay.outlines.push_back({"at rest", section(surface, surface.vertices, across, place)});
  }
  const Array<double> vertices = surface_at(stage.setup.body, stage.setup.scene, run.states.back());
  result_.overlays[0].outlines.push_back({name, section(surface, vertices, across, place)});
}

void Study::write_pvd(const std::string& name, const StudyStage& stage,
                      const Trajectory& run) const {
  const Scene& scene = stage.setup.scene;
  AnimationOptions options;
  options.fps = task_.scene.fps;
  options.generator = version_text();
  options.command = task_.scene.command;
  options.commit = build_commit();
  options.scene = &scene;
  const auto writer = AnimationWriter::create(task_.folder + "/" + name + ".pvd", asset_,
                                              stage.setup.body.surface, options);
  const Array<double> none(scene.grid.node_count(), 3);
  for (size_t n = 0; n < run.states.size(); n += size_t(stage.setup.substeps)) {
    const Array<double> displacement =
        displacements(scene, stage.setup.body.carried, run.states[n]);
    writer->frame({.displacement = displacement,
                   .gradient = {},
                   .state = &run.states[n],
                   .residual = none,
                   .certificate = {.converged = true}});
  }
  writer->finish();
}

}  // namespace elastogen
