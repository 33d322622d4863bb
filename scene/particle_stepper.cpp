// SPDX-License-Identifier: Apache-2.0
#include "scene/particle_stepper.hpp"

#include "core/reduce.hpp"
#include "core/stopwatch.hpp"
#include "mpm_fem/integrators/implicit_mpm.hpp"
#include "scene/host_stepper.hpp"
#include "scene/particle_setup.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

constexpr double kCells = 0.6;     // cells that a particle crosses in a part of a step at most
constexpr double kLongest = 2e-3;  // part of a step [s]
constexpr int kMostHalvings = 4;   // of a part that does not converge

/// The longest equal part of a time that is no longer than the limit.
double part_of(double time, double limit) {
  return time / std::ceil(time / limit - 1e-9);
}

mpm::MpmScene mpm_scene(const Setup& setup) {
  mpm::MpmScene scene;
  const Scene& of = setup.scene;
  scene.h = of.grid.h;
  scene.gravity = of.gravity;
  for (size_t k = 0; k < of.materials.size(); ++k)
    scene.solids.push_back({of.materials[k], setup.yields[k]});
  for (const Collider& collider : of.colliders) {
    mpm::Wall wall{.collider = collider};
    wall.collider.centre = minus(collider.centre, of.grid.origin);
    scene.walls.push_back(std::move(wall));
  }
  return scene;
}

class ParticleStepper : public HostStepper {
 public:
  ParticleStepper(const Setup& setup, const RunDescription& run, std::function<bool()> stop)
      : HostStepper(setup.particles->nodes),
        setup_(setup),
        stop_(std::move(stop)),
        scene_(mpm_scene(setup)),
        solver_(scene_, {.tolerance = run.solver.tolerance}),
        tolerance_(run.solver.tolerance) {}

  void begin(const StartMotion& motion) override;
  void begin_at(const State& state) override;
  StepReport advance() override;
  Span<const double> residual() const override { return none_; }
  void describe(StateHeader& header) const override;
  std::optional<StatePlastic> plastic() const override {
    return StatePlastic{yield_rows(setup_.yields), {}, {}};
  }
  const ParticleStrain* particles() override {
    strain_ = {particles_.F, particles_.C, particles_.stress, particles_.history};
    return &strain_;
  }

 private:
  double next_part(double left) const;
  mpm::MpmStepReport take_part(double& part);
  void measure(StepReport& report) const;
  void show();

  const Setup& setup_;
  std::function<bool()> stop_;
  mpm::MpmScene scene_;
  mpm::ImplicitMpm<3> solver_;
  double tolerance_;
  mpm::Particles particles_;
  ParticleStrain strain_;
  Array<double> none_;
};

void ParticleStepper::describe(StateHeader& header) const {
  header.solver = "mpm";
  header.element = "particle";
  header.scheme = "euler";
  header.tolerance = tolerance_;
  header.particles = particle_set(*setup_.particles);
}

void ParticleStepper::begin(const StartMotion& motion) {
  Scene nodes;  // only what initial_state looks at
  nodes.grid = setup_.particles->nodes;
  nodes.mass = setup_.particles->particles.mass;
  nodes.pinned = Array<uint8_t>(nodes.grid.node_count());
  begin_at(initial_state(nodes, motion));
}

void ParticleStepper::begin_at(const State& state) {
  HostStepper::begin_at(state);
  particles_ = setup_.particles->particles;
  particles_.v = state.v;
  const Vec3& origin = setup_.scene.grid.origin;
  for (int64_t k = 0; k < state.x.size(); ++k)
    particles_.x.data()[k] = state.x.data()[k] - origin[size_t(k % 3)];
}

/// A part of what is left of a step, so long that no particle crosses more than kCells.
double ParticleStepper::next_part(double left) const {
  const double h = scene_.h, g = norm(scene_.gravity);
  const double fastest = largest(particles_.count(), [&](int64_t k) {
    const double *v = particles_.v.row(k), *C = particles_.C.row(k);
    double spread = 0;
    for (int e = 0; e < 9; ++e) spread += C[e] * C[e];
    return std::hypot(v[0], v[1], v[2]) + h * std::sqrt(spread);
  });
  // v t + g t^2 = kCells h
  const double root = std::sqrt(fastest * fastest + 4 * g * kCells * h);
  return part_of(left, std::min(kLongest, 2 * kCells * h / (fastest + root)));
}

/// One part, halved until it converges; what the last try leaves is kept.
mpm::MpmStepReport ParticleStepper::take_part(double& part) {
  mpm::MpmStepReport report;
  for (int k = 0; k <= kMostHalvings; ++k) {
    mpm::Particles tried = particles_;
    scene_.dt = part;
    report = solver_.step(state_.time, tried);
    if (report.converged || k == kMostHalvings) {
      if (report.finite) particles_ = std::move(tried);
      return report;
    }
    part /= 2;
  }
  return report;
}

StepReport ParticleStepper::advance() {
  const Stopwatch watch;
  const mpm::Particles before = particles_;
  const State state_before = state_;
  StepReport all;
  all.step = state_.steps + 1;
  all.converged = all.float64 = true;
  const double end = state_.time + setup_.scene.dt;
  double left = setup_.scene.dt;
  while (left > 1e-9 * setup_.scene.dt) {
    all.interrupted = stop_();
    if (all.interrupted) break;
    double part = next_part(left);
    const mpm::MpmStepReport r = take_part(part);
    all.outer += r.outer;
    all.inner += r.inner;
    all.converged &= r.converged;
    all.residual = std::max(all.residual, r.residual);
    all.finite = r.finite;
    if (!r.finite) break;
    state_.time += part;
    left -= part;
  }
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

/// Energies, the smallest volume ratio, and how deep particles are inside of colliders.
void ParticleStepper::measure(StepReport& report) const {
  const mpm::Particles& p = particles_;
  const std::vector<mpm::Wall>& walls = scene_.walls;
  report.energy.kinetic = mpm::kinetic_energy(p, scene_.h);
  report.min_j = 1e300;
  double deepest = 0;
  for (int64_t k = 0; k < p.count(); ++k) {
    const Mat3<double> F = load_matrix(p.F.row(k));
    report.min_j = std::min(report.min_j, determinant(F));
    for (int a = 0; a < 3; ++a)
      report.energy.gravity -= p.mass(k) * scene_.gravity[size_t(a)] * state_.x(k, a);
    std::visit(
        [&](const auto& law) {
          report.energy.elastic +=
              p.volume(k) * energy_density(law, F, history_of(law, p.history(k)));
        },
        solver_.laws()[size_t(p.solid(k))]);
    for (const mpm::Wall& wall : walls) {
      const Vec3 x = {p.x(k, 0), p.x(k, 1), p.x(k, 2)};
      const double distance =
          proximity(wall.collider, offset_at(wall.collider, state_.time), x).distance;
      deepest = std::max(deepest, -distance);
    }
  }
  report.deepest_overlap = deepest / scene_.h;
}

/// Brings the positions up to date.
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
