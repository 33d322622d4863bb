// SPDX-License-Identifier: Apache-2.0
#include "scene/particle_integrator.hpp"

#include "core/error.hpp"
#include "core/reduce.hpp"
#include "core/stopwatch.hpp"
#include "core/svd2.hpp"
#include "mpm_fem/integrators/explicit_mpm.hpp"
#include "mpm_fem/integrators/fixed_point_mpm.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

constexpr double kStable = 0.3;  // default of an explicit substep [h/c]

/// sum V psi over the particles, each by the law of its solid.
template <int d>
double energy_of(const std::vector<PointLaw<d>>& laws, const mpm::Particles& p) {
  return ordered_sum(p.count(), [&](int64_t begin, int64_t end) {
    double sum = 0;
    for (int64_t k = begin; k < end; ++k)
      std::visit(
          [&](const auto& law) {
            const Svd3<double> F = decompose<d>(load_matrix(p.F.row(k)));
            sum += p.volume(k) *
                   law.template response<false>(F.sigma, history_of(law, p.history(k))).psi;
          },
          laws[size_t(p.solid(k))]);
    return sum;
  });
}

/// Steps of ImplicitMpm or FixedPointMpm.
template <int d, class Solver>
class ImplicitParticles : public ParticleIntegrator {
 public:
  template <class Options>
  ImplicitParticles(const mpm::MpmScene& scene, const Options& options) : solver_(scene, options) {}

  mpm::MpmStepReport step(double time, mpm::Particles& particles) override {
    return solver_.step(time, particles);
  }
  double elastic_energy(const mpm::Particles& particles) const override {
    return energy_of<d>(solver_.laws(), particles);
  }

 private:
  Solver solver_;
};

template <int d>
class ExplicitParticles : public ParticleIntegrator {
 public:
  ExplicitParticles(const mpm::MpmScene& scene, int substeps)
      : scene_(scene), solver_(scene, substeps) {
    for (const Solid& solid : scene.solids) laws_.push_back(point_law<d>(solid));
  }

  mpm::MpmStepReport step(double time, mpm::Particles& particles) override {
    const Stopwatch watch;
    mpm::MpmStepReport report;
    report.finite = take_step(time, particles);
    report.converged = report.finite;
    report.float64 = true;
    report.time = time + scene_.dt;
    report.ms = watch.milliseconds();
    return report;
  }
  double elastic_energy(const mpm::Particles& particles) const override {
    return energy_of<d>(laws_, particles);
  }

 private:
  /// Makes a step. @return whether a grid can hold the particles before and after.
  bool take_step(double time, mpm::Particles& particles) {
    try {
      solver_.step(time, particles);
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::kResources) throw;
      return false;
    }
    return all_finite(particles.x.data(), particles.x.size());
  }

  const mpm::MpmScene& scene_;
  mpm::ExplicitMpm<d> solver_;
  std::vector<PointLaw<d>> laws_;
};

void check_stable(const mpm::MpmScene& scene, const ParticleOptions& options) {
  const double step = scene.dt / options.substeps, crossing = crossing_time(scene);
  ELASTOGEN_CHECK(step <= crossing, "particles: explicit steps of ", step,
                  " s blow up, waves cross ", "a cell in ", crossing,
                  " s: give a smaller --dt or more --particle-substeps");
}

template <int d>
std::unique_ptr<ParticleIntegrator> integrator_in(const mpm::MpmScene& scene,
                                                  const ParticleOptions& options,
                                                  double tolerance) {
  mpm::FixedPointOptions passes{.tolerance = tolerance};
  switch (options.integrator) {
    case Integrator::kImplicit:
      return std::make_unique<ImplicitParticles<d, mpm::ImplicitMpm<d>>>(
          scene, mpm::ImplicitMpmOptions{.tolerance = tolerance});
    case Integrator::kPnFixedPoint:
      passes.published = true;
      passes.passes = options.passes;
      [[fallthrough]];
    case Integrator::kFrozenFixedPoint:
      return std::make_unique<ImplicitParticles<d, mpm::FixedPointMpm<d>>>(scene, passes);
    default:
      check_stable(scene, options);
      return std::make_unique<ExplicitParticles<d>>(scene, options.substeps);
  }
}

}  // namespace

std::string_view integrator_name(Integrator integrator) {
  constexpr std::string_view kNames[] = {"implicit", "explicit", "frozen-fixed-point",
                                         "pn-fixed-point"};
  return kNames[int(integrator)];
}

mpm::MpmScene mpm_scene(const Setup& setup, const ParticleOptions& options) {
  mpm::MpmScene scene;
  const Scene& of = setup.scene;
  scene.dimension = setup.particles->dimension;
  scene.h = of.grid.h;
  scene.gravity = of.gravity;
  scene.transfer = options.transfer;
  for (size_t k = 0; k < of.materials.size(); ++k)
    scene.solids.push_back({of.materials[k], setup.yields[k]});
  for (const Collider& collider : of.colliders) {
    mpm::Obstacle obstacle{collider, collider.friction == kSticks};
    obstacle.collider.centre = minus(collider.centre, of.grid.origin);
    scene.obstacles.push_back(std::move(obstacle));
  }
  for (const Border& border : setup.particles->held) scene.obstacles.push_back({{}, true, border});
  return scene;
}

double crossing_time(const mpm::MpmScene& scene) {
  double fastest = 0;
  for (const Solid& solid : scene.solids)
    fastest = std::max(fastest, mpm::wave_speed(solid.elastic));
  return scene.h / fastest;
}

double explicit_dt(const mpm::MpmScene& scene, const ParticleOptions& options) {
  return options.dt > 0 ? options.dt : options.substeps * kStable * crossing_time(scene);
}

std::unique_ptr<ParticleIntegrator> make_particle_integrator(const mpm::MpmScene& scene,
                                                             const ParticleOptions& options,
                                                             double tolerance) {
  if (scene.dimension == 2) return integrator_in<2>(scene, options, tolerance);
  return integrator_in<3>(scene, options, tolerance);
}

}  // namespace elastogen
