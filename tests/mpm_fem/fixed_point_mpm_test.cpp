// SPDX-License-Identifier: Apache-2.0
// Minima with the plastic part frozen: their energy, and steps by them against Newton's.
#include "mpm_fem/integrators/fixed_point_mpm.hpp"

#include "tests/mpm_fem/particle_scenes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace elastogen::mpm {
namespace {

using test::column, test::column_scene, test::particle_scene, test::particle_solid,
    test::random_particles, test::sand;
using Vector = std::vector<double>;

Solid snow(double young) {
  Solid s = particle_solid(young, 300);
  s.yield = SnowYield{.cohesion = 1, .pressure = 3e-3 * young};
  return s;
}

Solid metal(double young) {
  Solid s = particle_solid(young, 1000);
  s.yield = MetalYield{.stress = 0.01 * young, .hardening = 0.1 * young};
  return s;
}

/// Particles that yield, at a plane along which they slide and one at which they stick; E is frozen
/// at the motion without stress.
template <int d>
struct FrozenState {
  MpmScene scene = particle_scene(d);
  Particles particles = random_particles<d>(d == 2 ? 400 : 1500, 21);
  MpmPotential<d> potential;
  Vector y, r;
  std::vector<uint8_t> is_at_obstacle;  // of each node

  FrozenState(const Solid& of, bool drag) : potential(with_obstacles(scene, of)) {
    potential.begin(particles, 0, 5e-3);
    y.resize(size_t(potential.unknowns())), r.resize(y.size());
    potential.predict(y.data());
    potential.residual(y.data(), r.data());
    potential.freeze(y.data(), drag);
    const ParticleGrid<d>& grid = potential.grid();
    for (int64_t i = 0; i < grid.nodes(); ++i)
      is_at_obstacle.push_back(grid.place(i)[0] <= -3 || grid.place(i)[1] <= -3);
  }

  static const MpmScene& with_obstacles(MpmScene& s, const Solid& of) {
    s.solids = {of};
    s.gravity = {2, -10, 0};
    s.obstacles.push_back({half_space({0, 1, 0}, -0.35, 0.2), false});
    s.obstacles.push_back({half_space({1, 0, 0}, -0.35, 0.2), true});
    return s;
  }
  Vector gradient(const Vector& at) {
    Vector g(at.size());
    potential.evaluate(at.data(), g.data());
    return g;
  }
  double energy(const Vector& at) {
    Vector g(at.size());
    return potential.evaluate(at.data(), g.data()).value;
  }
};

Vector moved(const Vector& y, double by, const Vector& way) {
  Vector result = y;
  for (size_t k = 0; k < y.size(); ++k) result[k] += by * way[k];
  return result;
}

template <int d>
void check_derivatives(const Solid& of, bool drag) {
  FrozenState<d> state(of, drag);
  const Vector g = state.gradient(state.y);
  const double size = norm(g.data(), int64_t(g.size()));
  // along motions that colliders leave free, as far as half a percent of strain
  Vector way = g;
  for (double& w : way) w /= size;
  const Vector at = moved(state.y, -1e-2, way);
  const Vector there = state.gradient(at);
  const double step = 1e-5;
  const Vector above = moved(at, step, way), below = moved(at, -step, way);
  const double slope = dot(there.data(), way.data(), int64_t(way.size()));
  EXPECT_NEAR((state.energy(above) - state.energy(below)) / (2 * step), slope,
              1e-6 * std::abs(slope));
  Vector product(way.size()), ends[2] = {state.gradient(below), state.gradient(above)};
  state.potential.linearise(at.data(), TangentKind::kTrue);
  state.potential.product(way.data(), product.data());
  double off = 0;
  for (size_t k = 0; k < way.size(); ++k)
    off += std::pow(product[k] - (ends[1][k] - ends[0][k]) / (2 * step), 2);
  EXPECT_LT(std::sqrt(off), 1e-4 * norm(product.data(), int64_t(product.size())));
}

TEST(MpmPotential, GradientAndHessianAreTheDerivativesOfTheEnergy) {
  for (const bool drag : {false, true}) {
    check_derivatives<2>(sand(1e5), drag);
    check_derivatives<3>(sand(1e5), drag);
    check_derivatives<2>(snow(1e5), drag);
    check_derivatives<3>(snow(1e5), drag);
    check_derivatives<2>(metal(1e5), drag);
  }
}

/// With the regulariser too, which has no force there; without the forces that colliders hold.
TEST(MpmPotential, GradientWhereItWasFrozenIsTheTrueResidual) {
  for (const Solid& of : {sand(1e5), snow(1e5), metal(1e5)}) {
    FrozenState<2> state(of, true);
    const Vector g = state.gradient(state.y);
    const double size = norm(state.r.data(), int64_t(state.r.size()));
    double held = 0;
    for (size_t k = 0; k < g.size(); ++k) held += g[k] * (state.r[k] - g[k]);
    EXPECT_LT(std::abs(held), 1e-10 * size * size);
    EXPECT_GT(norm(g.data(), int64_t(g.size())), 0.5 * size);
    double off = 0;
    for (size_t k = 0; k < g.size(); ++k)
      if (!state.is_at_obstacle[k / 3]) off = std::max(off, std::abs(g[k] - state.r[k]));
    EXPECT_LT(off, 1e-11 * size);
  }
}

/// Runs steps of a solver; each must converge.
template <class Solver>
Particles after(const MpmScene& scene, Particles p, Solver& solver, int steps,
                int* passes = nullptr) {
  for (int k = 0; k < steps; ++k) {
    const MpmStepReport report = solver.step(k * scene.dt, p);
    EXPECT_TRUE(report.converged) << k << ": " << report.residual << ' ' << report.passes;
    if (passes) *passes = std::max(*passes, report.passes);
  }
  return p;
}

double apart(const Particles& a, const Particles& b) {
  double most = 0;
  for (int64_t k = 0; k < a.x.size(); ++k)
    most = std::max(most, std::abs(a.x.data()[k] - b.x.data()[k]));
  return most;
}

/// On rough ground and where it slides. Passes see to friction too, alone where nothing is frozen.
TEST(FixedPointMpm, ConvergedPassesAndNewtonsStepsAgree) {
  constexpr double kTolerance = 1e-7;
  for (const auto& [of, friction] : {std::pair(sand(1e5), -1.0),
                                     {sand(1e5), 0.3},
                                     {sand(1e5, 0.5, true), 0.3},
                                     {snow(1e6), 0.6},
                                     {metal(1e5), 0.3},
                                     {particle_solid(1e5, 1000), 0.3}}) {
    const MpmScene scene = column_scene(of, 4e-3, friction);
    ImplicitMpm<2> newton(scene, {.tolerance = kTolerance});
    FixedPointMpm<2> passes(scene, {.tolerance = kTolerance});
    int most = 0;
    const Particles a = after(scene, column(3, 6), newton, 20);
    const Particles b = after(scene, column(3, 6), passes, 20, &most);
    EXPECT_GT(most, 1);
    EXPECT_LT(most, 16);
    EXPECT_LT(apart(a, b), 1e-7);
  }
}

/// In space.
TEST(FixedPointMpm, ACubeOfSandStepsAsByNewtonsMethod) {
  MpmScene scene = particle_scene(3);
  scene.solids = {sand(1e5)};
  scene.gravity = {0, -10, 0};
  scene.dt = 4e-3;
  scene.obstacles.push_back({half_space({0, 1, 0}, -0.5, 0.3), false});
  Particles start = random_particles<3>(1000, 23);
  start.v.fill(0), start.C.fill(0);
  ImplicitMpm<3> newton(scene, {.tolerance = 1e-6});
  FixedPointMpm<3> passes(scene, {.tolerance = 1e-6});
  EXPECT_LT(apart(after(scene, start, newton, 5), after(scene, start, passes, 5)), 1e-7);
}

/// Their potentials are exact: nothing is frozen.
TEST(FixedPointMpm, ElasticBodiesAndMetalNeedOnePass) {
  for (const Solid& of : {particle_solid(1e5, 1000), metal(1e5)})
    for (const double friction : {-1.0, 0.0}) {
      const MpmScene scene = column_scene(of, 4e-3, friction);
      ImplicitMpm<2> newton(scene, {.tolerance = 1e-8});
      FixedPointMpm<2> passes(scene, {.tolerance = 1e-8});
      int most = 0;
      const Particles a = after(scene, column(3, 6), newton, 20);
      const Particles b = after(scene, column(3, 6), passes, 20, &most);
      EXPECT_EQ(most, 1);
      EXPECT_LT(apart(a, b), 1e-9);
    }
}

/// How far the top of a column of sand comes down [m].
double settled(const MpmScene& scene, const FixedPointOptions& options) {
  Particles p = column(4, 8);
  FixedPointMpm<2> solver(scene, options);
  for (int k = 0; k < 20; ++k) EXPECT_TRUE(solver.step(k * scene.dt, p).finite);
  const Particles start = column(4, 8);
  double sum = 0;
  for (int64_t k = p.count() - 8; k < p.count(); ++k) sum += (start.x(k, 1) - p.x(k, 1)) / 8;
  return sum;
}

/// The regulariser is a viscosity mu dt that passes wear off.
TEST(FixedPointMpm, PublishedLoopSettlesTheMoreThePassesItTakes) {
  const MpmScene scene = column_scene(sand(1e5), 1e-2);
  const double converged = settled(scene, {.tolerance = 1e-6});
  double before = 0;
  for (const int passes : {1, 3, 8, 40}) {
    const double now = settled(scene, {.tolerance = 1e-6, .passes = passes, .published = true});
    std::printf("%d passes settle %.4f m of %.4f\n", passes, now, converged);
    EXPECT_GT(now, before);
    EXPECT_LT(now, converged);
    before = now;
  }
  EXPECT_GT(before, 0.9 * converged);
}

}  // namespace
}  // namespace elastogen::mpm
