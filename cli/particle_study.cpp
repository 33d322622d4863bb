// SPDX-License-Identifier: Apache-2.0
#include "cli/particle_study.hpp"

#include "cli/signals.hpp"
#include "cli/study_machine.hpp"
#include "core/error.hpp"
#include "core/reduce.hpp"
#include "core/vec3.hpp"
#include "scene/asset_stages.hpp"
#include "scene/particle_setup.hpp"
#include "scene/version.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>

namespace elastogen {
namespace {

constexpr double kImplicitDt = 1e-3;  // if the scene has none [s]
constexpr double kFineSubstep = 0.1;  // substep of the reference [h/c]
constexpr int kFiner = 4;             // substeps of the noise floor over those of the reference

/// A signal came; the run that it interrupted does not count.
struct Interrupted {};

class ParticleStudy {
 public:
  explicit ParticleStudy(const StudyTask& task)
      : task_(task), asset_(run_asset(task.scene)), setup_(set_up(asset_, task.scene)) {
    scene_ = mpm_scene(setup_, task.scene.particles);
    start_ = setup_.particles->particles;
    start_.v = particle_start(setup_, task.scene.motion).v;
    describe();
  }

  ParticleStudyResult run() {
    try {
      take_runs();
    } catch (const Interrupted&) {
    }
    compare_all();
    return std::move(result_);
  }

 private:
  void describe();
  void take_runs();
  std::string add(const char* kind, ParticleOptions options);
  void add_frame(const ParticleIntegrator& integrator, const mpm::Particles& particles, double time,
                 ParticleRun& run) const;
  void step_frame(ParticleIntegrator& integrator, int64_t frame, mpm::Particles& particles,
                  ParticleRun& run, std::vector<double>& seconds);
  void compare_all();

  const StudyTask& task_;
  Asset asset_;
  Setup setup_;
  mpm::MpmScene scene_;
  mpm::Particles start_;
  ParticleStudyResult result_;
};

void ParticleStudy::describe() {
  const AnimateOptions& o = task_.scene;
  constexpr const char* kTransfers[] = {"apic", "apic-blend", "rpic", "flip"};
  result_.scene = o.shape ? kind_name(o.shape->kind) : o.input;
  result_.command = o.command;
  result_.commit = build_commit();
  result_.date = utc_date();
  result_.cpu = this_machine().cpu;
  result_.threads = o.threads;
  result_.dimension = scene_.dimension;
  result_.particles = start_.count();
  result_.h = scene_.h;
  result_.crossing = crossing_time(scene_);
  result_.transfer = kTransfers[int(scene_.transfer.kind)];
}

void ParticleStudy::take_runs() {
  // implicit steps, and explicit substeps between the same transfers as the reference
  ParticleOptions implicit = task_.scene.particles, sub = implicit, plain = implicit;
  if (implicit.dt == 0) implicit.dt = kImplicitDt;
  implicit.integrator = Integrator::kImplicit;
  implicit.substeps = 1;
  sub.integrator = plain.integrator = Integrator::kExplicit;
  sub.dt = implicit.dt;
  if (sub.substeps == 1)
    sub.substeps = int(std::ceil(sub.dt / (kFineSubstep * result_.crossing) - 1e-9));
  result_.sub_reference = add("explicit-sub", sub);
  // the integrator of the scene too, if it is one of the minima
  add("implicit", implicit);
  const Integrator asked = task_.scene.particles.integrator;
  if (asked == Integrator::kFrozenFixedPoint || asked == Integrator::kPnFixedPoint) {
    implicit.integrator = asked;
    add(std::string(integrator_name(asked)).c_str(), implicit);
  }
  // explicit steps with a transfer after each
  plain.substeps = 1;
  double finest = 1e300;
  for (const double dt : task_.explicit_dts) {
    plain.dt = dt;
    const std::string name = add("explicit", plain);
    if (dt < finest) finest = dt, result_.explicit_reference = name;
  }
  // the reference with more substeps tells its own error
  if (!task_.noise_floor) return;
  sub.substeps *= kFiner;
  add("explicit-sub", sub);
}

/// Adds a run. @return its name.
std::string ParticleStudy::add(const char* kind, ParticleOptions options) {
  const double frame = 1 / task_.scene.fps;
  options.dt = frame / std::ceil(frame / options.dt - 1e-9);
  ParticleRun run;
  run.options = options;
  run.name = fmt::format("{} {:.4g}", kind, options.dt);
  if (options.substeps > 1) run.name += fmt::format("/{}", options.substeps);
  if (!task_.scene.quiet) fmt::print("{} ...\n", run.name);
  std::fflush(stdout);
  scene_.dt = options.dt;
  const auto integrator = make_particle_integrator(scene_, options, task_.scene.solver.tolerance);
  mpm::Particles particles = start_;
  std::vector<double> seconds;
  add_frame(*integrator, particles, 0, run);
  for (int64_t k = 1; k <= task_.scene.frames && !run.broke_off; ++k)
    step_frame(*integrator, k, particles, run, seconds);
  run.step_seconds = quantile(seconds, 0.5);
  result_.runs.push_back(std::move(run));
  return result_.runs.back().name;
}

void ParticleStudy::step_frame(ParticleIntegrator& integrator, int64_t frame,
                               mpm::Particles& particles, ParticleRun& run,
                               std::vector<double>& seconds) {
  // counts before the frame
  const auto steps = std::llround(1 / (task_.scene.fps * scene_.dt));
  const int64_t solves = run.solves, iterations = run.iterations, missed = run.not_converged;
  double residual = 0;
  // steps of one frame, each timed; a step without a finite result ends the run
  for (int64_t k = 0; k < steps; ++k) {
    if (pending_signal() != 0) throw Interrupted();
    const double time = double((frame - 1) * steps + k) * scene_.dt;
    const std::clock_t begin = std::clock();
    const mpm::MpmStepReport r = integrator.step(time, particles);
    const double taken = double(std::clock() - begin) / CLOCKS_PER_SEC;
    run.broke_off = !r.finite;
    if (run.broke_off) return;
    ++run.steps;
    run.solves += r.outer, run.iterations += r.inner, run.factored += r.factored;
    run.not_converged += !r.converged;
    residual = std::max(residual, r.residual);
    seconds.push_back(taken);
  }
  // what the frame added
  run.worst_residual = std::max(run.worst_residual, residual);
  add_frame(integrator, particles, double(frame) / task_.scene.fps, run);
  ParticleFrame& f = run.frames.back();
  f.solves = run.solves - solves, f.iterations = run.iterations - iterations;
  f.not_converged = run.not_converged - missed;
  f.residual = residual;
}

void ParticleStudy::add_frame(const ParticleIntegrator& integrator, const mpm::Particles& particles,
                              double time, ParticleRun& run) const {
  ParticleFrame& frame = run.frames.emplace_back();
  frame.time = time;
  frame.x = particles.x;
  frame.kinetic = mpm::kinetic_energy(particles, scene_.h);
  frame.elastic = integrator.elastic_energy(particles);
  frame.cloud = cloud_of(particles, plus(setup_.scene.place, setup_.scene.grid.origin));
}

/// Compares all runs with both references, frame by frame, as far as both have come.
void ParticleStudy::compare_all() {
  const double full = start_.count() > 0
                          ? scene_.solids[0].elastic.density * std::pow(scene_.h, scene_.dimension)
                          : 0;
  const auto compare_with = [&](const std::string& name, mpm::Likeness ParticleFrame::*to) {
    const ParticleRun* reference = result_.find(name);
    if (!reference) return;
    for (ParticleRun& run : result_.runs)
      for (size_t k = 0; k < std::min(run.frames.size(), reference->frames.size()); ++k) {
        mpm::Particles a = start_, b = start_;
        a.x = run.frames[k].x, b.x = reference->frames[k].x;
        run.frames[k].*to = mpm::compare(a, b, scene_.dimension, scene_.h, full);
      }
  };
  compare_with(result_.sub_reference, &ParticleFrame::to_sub);
  compare_with(result_.explicit_reference, &ParticleFrame::to_explicit);
}

}  // namespace

const ParticleRun* ParticleStudyResult::find(const std::string& name) const {
  for (const ParticleRun& run : runs)
    if (run.name == name) return &run;
  return nullptr;
}

LikenessRange range_of(const ParticleRun& run, mpm::Likeness ParticleFrame::*reference,
                       double mpm::Likeness::*which) {
  LikenessRange range;
  double sum = 0;
  for (size_t k = 1; k < run.frames.size(); ++k) {
    const double value = run.frames[k].*reference.*which;
    if (value < range.worst || std::isnan(value)) range.worst = value;
    sum += value;
  }
  if (run.frames.size() > 1) range.mean = sum / double(run.frames.size() - 1);
  return range;
}

ParticleStudyResult particle_study(const StudyTask& task) {
  return ParticleStudy(task).run();
}

}  // namespace elastogen
