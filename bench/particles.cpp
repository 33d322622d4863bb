// SPDX-License-Identifier: Apache-2.0
// Steps of particles: a cube of sand at random places on sticky ground, eight particles a cell in
// the mean, as after they have mixed.
#include "bench/bench.hpp"
#include "bench/timing.hpp"
#include "core/parallel.hpp"
#include "core/stopwatch.hpp"
#include "mpm_fem/integrators/explicit_mpm.hpp"
#include "mpm_fem/integrators/implicit_mpm.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>

namespace elastogen::bench {
namespace {

constexpr double kSpacing = 0.01;                             // of the grid [m]
constexpr double kSandDensity = 1000;                         // [kg/m^3]
constexpr double kExplicitStep = 7e-5, kImplicitStep = 1e-3;  // [s]
constexpr int kExplicitSteps = 20, kImplicitSteps = 5;        // that are timed
// what an explicit step must read (x v C F stress history mass volume solid) and write (x v C F
// stress history) of a particle
constexpr double kBytes = 8 * (3 + 3 + 9 + 9 + 6 + 1 + 2) + 4 + 8 * (3 + 3 + 9 + 9 + 6 + 1);

mpm::MpmScene sand_scene(double dt) {
  mpm::MpmScene scene;
  scene.h = kSpacing;
  scene.dt = dt;
  scene.gravity = {0, -9.81, 0};
  Solid sand;
  sand.elastic = {"sand", Law::kHencky, 1e6, 0.35, kSandDensity};
  sand.yield = SandYield{std::numbers::pi / 6, 0, false};
  scene.solids = {sand};
  scene.obstacles.push_back({half_space({0, 1, 0}, 0, 0), true});
  return scene;
}

mpm::Particles cube_of(int64_t count) {
  const double edge = kSpacing * std::cbrt(double(count) / 8);
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> in(0, edge);
  Array<double> x(count, 3);
  for (int64_t k = 0; k < x.size(); ++k) x.data()[k] = in(random);
  return mpm::particles_at(x, edge * edge * edge / double(count), 0, kSandDensity);
}

struct Measured {
  Spread ms;
  double newton = 0, inner = 0;  // a step
  int steps = 0, converged = 0;
  double bytes = 0;  // of the solver and its particles
};

/// step() gives its report.
template <class Step>
Measured timed(int steps, const Step& step) {
  Measured m;
  std::vector<double> ms;
  step();
  for (int k = 0; k < steps; ++k) {
    const Stopwatch watch;
    const StepReport report = step();
    ms.push_back(watch.milliseconds());
    m.newton += double(report.outer) / steps;
    m.inner += double(report.inner) / steps;
    m.converged += report.converged;
  }
  m.steps = steps;
  m.ms = spread_of(ms);
  return m;
}

Measured measure_one(bool implicit, int64_t count, int repeats) {
  const int64_t before = resident_bytes();
  const mpm::MpmScene scene = sand_scene(implicit ? kImplicitStep : kExplicitStep);
  mpm::Particles particles = cube_of(count);
  double time = 0;
  Measured m;
  if (implicit) {
    mpm::ImplicitMpm<3> solver(scene);
    m = timed(repeats ? repeats : kImplicitSteps,
              [&] { return solver.step(std::exchange(time, time + scene.dt), particles); });
    m.bytes = double(resident_bytes() - before);
  } else {
    mpm::ExplicitMpm<3> solver(scene);
    m = timed(repeats ? repeats : kExplicitSteps, [&] {
      solver.step(std::exchange(time, time + scene.dt), particles);
      return StepReport{};
    });
    m.bytes = double(resident_bytes() - before);
  }
  return m;
}

Json row_of(bool implicit, int64_t count, int threads, const Measured& m, const CopyRates& rates) {
  const double updates = 1e3 * double(count) / m.ms.median;
  const double share = kBytes * updates / rates.host;
  // print the result
  fmt::print("{} {:8} particles, {} threads: {:9.2f} ms, {:5.2f} million updates/s",
             implicit ? "implicit" : "explicit", count, threads, m.ms.median, 1e-6 * updates);
  if (implicit)
    fmt::print(", {:.1f} Newton, {:.0f} GMRES, {} of {} certified", m.newton, m.inner, m.converged,
               m.steps);
  else
    fmt::print(", {:.0f} % of a copy", 100 * share);
  fmt::print(", {:.0f} B a particle\n", m.bytes / double(count));
  std::fflush(stdout);
  // members of both integrators, then those of one
  Json row = {{"integrator", implicit ? "implicit" : "explicit"},
              {"particles", count},
              {"threads", threads},
              {"dt", implicit ? kImplicitStep : kExplicitStep},
              {"ms", m.ms.median},
              {"ms_lower_quartile", m.ms.lower},
              {"ms_upper_quartile", m.ms.upper},
              {"updates_per_second", updates},
              {"memory_bytes_a_particle", m.bytes / double(count)}};
  if (implicit) {
    row["newton_a_step"] = m.newton;
    row["iterations_a_step"] = m.inner;
    row["steps"] = m.steps;
    row["certified"] = m.converged;
  } else {
    row["copy_share"] = share;
  }
  return row;
}

}  // namespace

Json measure_particles(const BenchTask& task, const CopyRates& rates) {
  std::vector<double> sizes = task.sizes;
  if (sizes.empty()) sizes = {1e4, 1e5, 1e6};
  const int all = thread_count();
  Json result = Json::array();
  for (const double size : sizes)
    for (const std::string& name : task.integrators)
      for (int threads = 1;; threads = std::min(2 * threads, all)) {
        const ThreadLimit limit(threads);
        const auto count = int64_t(size);
        const bool implicit = name == "implicit";
        const Measured m = measure_one(implicit, count, task.repeats);
        result.push_back(row_of(implicit, count, threads, m, rates));
        if (threads == all) break;
      }
  return result;
}

}  // namespace elastogen::bench
