// SPDX-License-Identifier: Apache-2.0
// Waves and vibrations of a bar and a beam, against one-dimensional theory.
#include "network/contact/contact.hpp"
#include "network/solver.hpp"
#include "tests/network/scenes.hpp"

#include <gtest/gtest.h>

namespace elastogen::test {
namespace {

/// A free bar of n voxels along x, one voxel thick, with c = sqrt(E/rho) = 1 h per unit of time.
Scene unit_bar(int n, double dt) {
  Scene scene = scene_on(make_box(n, 1, 1, 1), solid(1, 0, Law::kFixedCorotated, 1));
  scene.scheme = TimeScheme::kBdf2;
  scene.dt = dt;
  finish_scene(scene);
  return scene;
}

TEST(Waves, APulseTravelsAlongABarWithTheSpeedOfTheBar) {
  // E3: a pulse that moves to the right, u = f(x - t), v = -f'(x - t); c = 1 cell per unit of time
  constexpr int kCells = 120, kStart = 30, kEnd = 90;
  constexpr double kStep = 0.25, kWidth = 6, kSize = 1e-3;
  const Scene scene = unit_bar(kCells, kStep);
  State state = initial_state(scene);
  for (int64_t n = 0; n < scene.grid.node_count(); ++n) {
    const double s = (scene.grid.rest(n, 0) - kStart) / kWidth, f = kSize * std::exp(-s * s / 2);
    state.x(n, 0) += f;
    state.v(n, 0) = f * s / kWidth;
  }
  Solver solver(scene, {.mode = SolverMode::kNewton, .tolerance = 1e-7});
  int64_t watched = -1;
  for (int64_t n = 0; n < scene.grid.node_count(); ++n)
    if (scene.grid.node_coord(n, 0) == kEnd) watched = n;
  double largest = 0, arrival = 0;
  while (state.time < 80) {
    ASSERT_TRUE(solver.step(state).converged);
    const double u = state.x(watched, 0) - scene.grid.rest(watched, 0);
    if (u > largest) largest = u, arrival = state.time;
  }
  printf("pulse: arrival after %.2f of %d cells / c, height kept %.3f\n", arrival, kEnd - kStart,
         largest / kSize);
  EXPECT_NEAR(arrival, kEnd - kStart, 1 + kStep);
}

/// Frequency of an oscillating signal from its crossings of zero, [1/step].
class Frequency {
 public:
  void add(double value) {
    if (steps_ > 0 && value * before_ <= 0) {
      last_ = steps_ - value / (value - before_);
      if (crossings_++ == 0) first_ = last_;
    }
    before_ = value;
    ++steps_;
  }
  int crossings() const { return crossings_; }
  double value() const { return (crossings_ - 1) / 2.0 / (last_ - first_); }

 private:
  double before_ = 0, first_ = 0, last_ = 0;
  int steps_ = 0, crossings_ = 0;
};

TEST(Waves, AStandingWaveOfAHundredCellsHasTheFrequencyOfTheBar) {
  // E3: lowest mode of a free bar of 50 cells, wavelength 100 cells, period 100
  constexpr int kCells = 50;
  const Scene scene = unit_bar(kCells, 1);
  State state = initial_state(scene);
  for (int64_t n = 0; n < scene.grid.node_count(); ++n)
    state.x(n, 0) += 1e-3 * std::cos(M_PI * scene.grid.rest(n, 0) / kCells);
  Solver solver(scene, {.mode = SolverMode::kNewton, .tolerance = 1e-8});
  Frequency frequency;
  while (frequency.crossings() < 5) {
    ASSERT_TRUE(solver.step(state).converged);
    frequency.add(state.x(0, 0));
  }
  printf("standing wave: period %.3f of 100\n", 1 / frequency.value());
  EXPECT_NEAR(100 * frequency.value(), 1, 0.02);
}

/// Shape of the clamped-free beam of length 1 with the root beta.
double mode_shape(double beta, double x) {
  const double ratio = (std::cosh(beta) + std::cos(beta)) / (std::sinh(beta) + std::sin(beta));
  return std::cosh(beta * x) - std::cos(beta * x) -
         ratio * (std::sinh(beta * x) - std::sin(beta * x));
}

/// Frequency [Hz] of a clamped beam, 0.1 x 0.1, L = 1, E = 1e8, rho = 1000, nu = 0, four voxels
/// thick, that starts in a bending mode of Euler and Bernoulli and vibrates along it.
double beam_frequency(double beta, double dt, double size) {
  constexpr int kThick = 4;
  Scene scene = scene_on(make_box(10 * kThick, kThick, kThick, 0.1 / kThick), solid(1e8, 0));
  pin_below(scene, 0, 0.1 / kThick / 2);
  scene.scheme = TimeScheme::kBdf2;
  scene.dt = dt;
  finish_scene(scene);
  State state = initial_state(scene);
  // the mode as displacement, with turned sections
  std::vector<double> shape(size_t(scene.grid.node_count()));
  for (int64_t n = 0; n < scene.grid.node_count(); ++n) {
    if (scene.pinned(n)) continue;
    const double x = scene.grid.rest(n, 0), y = scene.grid.rest(n, 1) - 0.05, e = 1e-5;
    const double slope = (mode_shape(beta, x + e) - mode_shape(beta, x - e)) / (2 * e);
    shape[size_t(n)] = mode_shape(beta, x);
    state.x(n, 1) += size * shape[size_t(n)];
    state.x(n, 0) -= size * slope * y;
  }
  // amplitude along the mode, until it has crossed zero five times
  Solver solver(scene, {.mode = SolverMode::kNewton, .tolerance = 1e-4});
  Frequency frequency;
  while (frequency.crossings() < 5) {
    const StepReport report = solver.step(state);
    EXPECT_TRUE(report.converged) << report.residual;
    double along = 0;
    for (int64_t n = 0; n < scene.grid.node_count(); ++n)
      along += scene.mass(n) * shape[size_t(n)] * (state.x(n, 1) - scene.grid.rest(n, 1));
    frequency.add(along);
  }
  return frequency.value() / dt;
}

TEST(Waves, AClampedBeamVibratesAtTheFrequenciesOfTimoshenko) {
  // E1: Euler-Bernoulli has 5.1083 and 32.013 Hz; Timoshenko's equations (shear factor 10/12,
  // rotary inertia), solved by a transfer matrix, 5.0751 and 30.6436 Hz
  const struct {
    double beta, reference, size;  // accelerations of a few g, small slopes
  } modes[] = {{1.87510407, 5.07511, 1e-2}, {4.69409113, 30.64358, 1e-3}};
  for (const auto& mode : modes) {
    const double f = beam_frequency(mode.beta, 1 / (100 * mode.reference), mode.size);
    printf("beam: %.4f Hz, Timoshenko %.4f, %+.2f %%\n", f, mode.reference,
           100 * (f / mode.reference - 1));
    EXPECT_NEAR(f / mode.reference, 1, 0.01);
  }
}

TEST(Waves, ABarThatHitsAWallReturnsAfterTwoLengths) {
  // E4: contact for 2 L/c, obstacle stress rho c v0, rebound at -v0; the bar is linear (corotated,
  // nu = 0), c = 1, v0 = 0.1 c; the layer of the contact is h/4 deep and yields
  constexpr int kCells = 80;
  constexpr double kSpeed = 0.1, kStep = 0.2, kArea = 4;
  Scene scene = scene_on(make_box(2, kCells, 2, 1), solid(1, 0, Law::kFixedCorotated, 1));
  scene.surface = face_points(scene.grid);
  scene.colliders = {half_space({0, 1, 0}, 0, 0)};
  scene.scheme = TimeScheme::kBdf2;
  scene.dt = kStep;
  finish_scene(scene);
  Solver solver(scene, {.mode = SolverMode::kNewton, .tolerance = 1e-6});
  State state = initial_state(scene, {.velocity = {0, -kSpeed, 0}});
  Contact contact(scene);
  double begin = -1, end = 0, push = 0, held = 0, speed = 0;
  while (state.time < 2.5 * kCells) {
    ASSERT_TRUE(solver.step(state).converged);
    const std::vector<double> u = displacement(scene, state);
    std::vector<double> g(u.size());
    contact.evaluate(u.data(), g.data());
    double force = 0;
    for (size_t k = 1; k < g.size(); k += 3) force -= g[k];
    if (force > 0.1 * kSpeed * kArea) end = state.time, begin = begin < 0 ? end : begin;
    if (state.time > 0.5 * kCells && state.time < 1.5 * kCells) push += force, held += 1;
  }
  for (int64_t n = 0; n < scene.grid.node_count(); ++n)
    speed += scene.mass(n) * state.v(n, 1) / (kCells * kArea);
  printf("impact: contact %.3f of 2 L/c, obstacle stress %.4f of rho c v0, rebound %.4f of v0\n",
         (end - begin) / (2 * kCells), push / held / (kSpeed * kArea), speed / kSpeed);
  EXPECT_NEAR((end - begin) / (2 * kCells), 1, 0.02);
  EXPECT_NEAR(push / held / (kSpeed * kArea), 1, 0.02);
  EXPECT_NEAR(speed / kSpeed, 1, 0.02);
}

}  // namespace
}  // namespace elastogen::test
