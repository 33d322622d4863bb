// SPDX-License-Identifier: Apache-2.0
#include "scene/particle_stepper.hpp"

#include "core/error.hpp"
#include "core/reduce.hpp"
#include "core/stopwatch.hpp"
#include "core/vec3.hpp"
#include "scene/host_stepper.hpp"
#include "scene/particle_integrator.hpp"
#include "scene/particle_setup.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

constexpr double kCells = 0.6;          // most cells that a particle crosses in a part of a step
constexpr double kLongest = 2e-3;       // longest part of a step [s]
constexpr double kShortest = 1.0 / 16;  // shortest part that halving gives, over the longest
constexpr double kTolerance = 1e-3;     // default tolerance

/// The length of equal parts of a time, as few as keep the limit.
double part_of(double time, double limit) {
  return time / std::ceil(time / limit - 1e-9);
}

class ParticleStepper : public HostStepper {
 public:
  ParticleStepper(const Setup& setup, const RunDescription& run, std::function<bool()> stop)
      : HostStepper(setup.particles->nodes),
        setup_(setup),
        options_(run.particles),
        stop_(std::move(stop)),
        scene_(mpm_scene(setup, run.particles)),
        tolerance_(run.fem && run.fem->any_rounding ? kTolerance : run.solver.tolerance) {
    if (is_explicit()) options_.dt = explicit_dt(scene_, options_);
    scene_.dt = options_.dt > 0 ? std::min(options_.dt, setup.scene.dt) : setup.scene.dt;
    integrator_ = make_particle_integrator(scene_, options_, tolerance_);
  }

  void begin(const StartMotion& motion) override;
  void begin_at(const State& state) override;
  StepReport advance() override;
  Span<const double> residual() const override { return none_; }
  std::optional<CloudReport> cloud() const override {
    return cloud_of(particles_, plus(setup_.scene.place, setup_.scene.grid.origin));
  }
  void describe(StateHeader& header) const override;
  std::optional<StatePlastic> plastic() const override {
    return StatePlastic{yield_rows(setup_.yields), {}, {}};
  }
  const ParticleStrain* particles() override {
    strain_ = {particles_.F, particles_.C, particles_.stress, particles_.history};
    return &strain_;
  }

 private:
  bool is_explicit() const { return options_.integrator == Integrator::kExplicit; }
  /// Whether a part that does not converge is halved; not in the published loop.
  bool halves() const { return !is_explicit() && options_.integrator != Integrator::kPnFixedPoint; }
  double longest_part() const;
  mpm::MpmStepReport take_part(double shortest, double& part);
  void measure(StepReport& report) const;
  void measure_overlap(StepReport& report) const;
  void show();

  const Setup& setup_;
  ParticleOptions options_;
  std::function<bool()> stop_;
  mpm::MpmScene scene_;
  double tolerance_;
  std::unique_ptr<ParticleIntegrator> integrator_;
  mpm::Particles particles_;
  ParticleStrain strain_;
  Array<double> none_;
};

void ParticleStepper::describe(StateHeader& header) const {
  header.solver = options_.integrator == Integrator::kImplicit
                      ? "mpm"
                      : concat("mpm-", integrator_name(options_.integrator));
  header.element = "particle";
  header.scheme = "euler";
  header.tolerance = tolerance_;
  header.particles = particle_set(*setup_.particles);
}

void ParticleStepper::begin(const StartMotion& motion) {
  begin_at(particle_start(setup_, motion));
}

void ParticleStepper::begin_at(const State& state) {
  HostStepper::begin_at(state);
  particles_ = setup_.particles->particles;
  particles_.v = state.v;
  const Vec3& origin = setup_.scene.grid.origin;
  for (int64_t k = 0; k < state.x.size(); ++k)
    particles_.x.data()[k] = state.x.data()[k] - origin[size_t(k % 3)];
}

/// The dt of the options, or a time in which no particle crosses more than kCells cells [s].
double ParticleStepper::longest_part() const {
  if (options_.dt > 0) return options_.dt;
  const double h = scene_.h, g = norm(scene_.gravity);
  const double fastest = largest(particles_.count(), [&](int64_t k) {
    const double *v = particles_.v.row(k), *C = particles_.C.row(k);
    double spread = 0;
    for (int e = 0; e < 9; ++e) spread += C[e] * C[e];
    return std::hypot(v[0], v[1], v[2]) + h * std::sqrt(spread);
  });
  // v t + g t^2 = kCells h
  const double root = std::sqrt(fastest * fastest + 4 * g * kCells * h);
  return std::min(kLongest, 2 * kCells * h / (fastest + root));
}

/// Makes one part, halved until it converges. The result of the last try is kept.
mpm::MpmStepReport ParticleStepper::take_part(double shortest, double& part) {
  int outer = 0, inner = 0;  // iterations of tries that were undone
  for (int k = 0;; ++k) {
    mpm::Particles tried = particles_;
    scene_.dt = part;
    mpm::MpmStepReport report = integrator_->step(state_.time, tried);
    outer = report.outer += outer;
    inner = report.inner += inner;
    report.fallbacks = k;
    if (report.converged || !halves() || part / 2 < (1 - 1e-9) * shortest) {
      if (report.finite) particles_ = std::move(tried);
      return report;
    }
    part /= 2;
  }
}

namespace {

/// Adds a part to the report of its step.
void add_part(const mpm::MpmStepReport& part, StepReport& all) {
  all.outer += part.outer;
  all.inner += part.inner;
  all.fallbacks += part.fallbacks;
  all.converged &= part.converged;
  all.residual = std::max(all.residual, part.residual);
  all.finite = part.finite;
}

}  // namespace

StepReport ParticleStepper::advance() {
  const Stopwatch watch;
  const mpm::Particles before = particles_;
  const State state_before = state_;
  StepReport all;
  all.step = state_.steps + 1;
  all.converged = all.float64 = true;
  const double end = state_.time + setup_.scene.dt;
  double left = setup_.scene.dt, before_it = left;  // a part is at most twice the part before it
  while (left > 1e-9 * setup_.scene.dt) {
    all.interrupted = stop_();
    if (all.interrupted) break;
    const double longest = longest_part();
    double part = part_of(left, std::min(longest, 2 * before_it));
    const double shortest = kShortest * std::min(longest, setup_.scene.dt);
    const mpm::MpmStepReport r = take_part(shortest, part);
    before_it = part;
    add_part(r, all);
    if (!r.finite) break;
    state_.time += part;
    left -= part;
  }
  // a step that was given up leaves the state as it was
  if (all.interrupted || !all.finite) {
    particles_ = before;
    state_ = state_before;
    return all;
  }
  state_.time = all.time = end;
  ++state_.steps;
  show();
  measure(all);
  all.ms = watch.milliseconds();
  return all;
}

/// Adds energies, the smallest volume ratio and the extent of the particles to the report.
void ParticleStepper::measure(StepReport& report) const {
  const mpm::Particles& p = particles_;
  report.energy.kinetic = mpm::kinetic_energy(p, scene_.h);
  report.energy.elastic = integrator_->elastic_energy(p);
  report.min_j = 1e300;
  for (int64_t k = 0; k < p.count(); ++k) {
    report.min_j = std::min(report.min_j, determinant(load_matrix(p.F.row(k))));
    for (size_t a = 0; a < 3; ++a)
      report.energy.gravity -= p.mass(k) * scene_.gravity[a] * state_.x(k, int(a));
  }
  measure_overlap(report);
}

/// Adds how deep particles are inside colliders to the report.
void ParticleStepper::measure_overlap(StepReport& report) const {
  double deepest = 0;
  for (const mpm::Obstacle& obstacle : scene_.obstacles) {
    if (obstacle.held) continue;
    const Vec3 offset = offset_at(obstacle.collider, state_.time);
    for (int64_t k = 0; k < particles_.count(); ++k) {
      const double* x = particles_.x.row(k);
      deepest =
          std::max(deepest, -proximity(obstacle.collider, offset, {x[0], x[1], x[2]}).distance);
    }
  }
  report.deepest_overlap = deepest / scene_.h;
}

/// Updates the positions in state_.
void ParticleStepper::show() {
  const Vec3& origin = setup_.scene.grid.origin;
  for (int64_t k = 0; k < state_.x.size(); ++k)
    state_.x.data()[k] = particles_.x.data()[k] + origin[size_t(k % 3)];
  state_.v = particles_.v;
}

}  // namespace

double longest_part(double dt) {
  return part_of(dt, kLongest);
}

std::unique_ptr<Stepper> make_particle_stepper(const Setup& setup, const RunDescription& run,
                                               std::function<bool()> stop) {
  return std::make_unique<ParticleStepper>(setup, run, std::move(stop));
}

}  // namespace elastogen
