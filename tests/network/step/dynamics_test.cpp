// SPDX-License-Identifier: Apache-2.0
// Conservation laws and orders of the time integration, on the solver as a whole.
#include "core/time_scheme.hpp"
#include "network/solver.hpp"
#include "tests/network/scenes.hpp"

#include <gtest/gtest.h>

namespace elastogen::test {
namespace {

/// A free block without gravity.
Scene free_block(int nx, int ny, int nz, double h, const Material& material) {
  Scene scene = scene_on(make_box(nx, ny, nz, h), material);
  finish_scene(scene);
  return scene;
}

Vec3 momentum(const Scene& scene, const State& state) {
  Vec3 sum = {};
  for (int64_t n = 0; n < scene.grid.node_count(); ++n)
    for (int i = 0; i < 3; ++i) sum[size_t(i)] += scene.mass(n) * state.v(n, i);
  return sum;
}

/// Angular momentum about z through the centre of mass of a body whose centre rests.
double spin_momentum(const Scene& scene, const State& state, const double centre[2]) {
  double sum = 0;
  for (int64_t n = 0; n < scene.grid.node_count(); ++n)
    sum += scene.mass(n) * ((state.x(n, 0) - centre[0]) * state.v(n, 1) -
                            (state.x(n, 1) - centre[1]) * state.v(n, 0));
  return sum;
}

double vector_length(const Vec3& v) {
  return std::hypot(v[0], v[1], v[2]);
}

/// Change of momentum over sum m |v| at the start, after steps that converge.
double momentum_lost(const Scene& scene, const SolverOptions& options, const StartMotion& motion,
                     int steps) {
  Solver solver(scene, options);
  State state = initial_state(scene, motion);
  const Vec3 start = momentum(scene, state);
  double size = 0;
  for (int64_t n = 0; n < scene.grid.node_count(); ++n)
    size += scene.mass(n) * std::hypot(state.v(n, 0), state.v(n, 1), state.v(n, 2));
  for (int k = 0; k < steps; ++k) EXPECT_TRUE(solver.step(state).converged) << k;
  const Vec3 end = momentum(scene, state);
  return vector_length({end[0] - start[0], end[1] - start[1], end[2] - start[2]}) / size;
}

TEST(Dynamics, MomentumIsKeptOverTenThousandSteps) {
  // E5, a soft body that spins in its place or flies
  const Scene scene = free_block(2, 2, 2, 0.1, solid(2e4, 0.3));
  for (const bool flies : {false, true}) {
    StartMotion motion{.spin = {3, 4, 5}};
    if (flies) motion.velocity[0] = 0.1, motion.velocity[1] = -0.2, motion.velocity[2] = 0.3;
    const double lost =
        momentum_lost(scene, {.mode = SolverMode::kQuasi, .tolerance = 1e-7}, motion, 10000);
    printf("momentum, %s: change after 10000 steps %.1e of sum m |v|\n",
           flies ? "flying" : "spinning in its place", lost);
    EXPECT_LT(lost, 1e-12);
  }
}

TEST(Dynamics, MomentumIsKeptAtAnyToleranceByAllSchemesAndSolvers) {
  Scene scene = free_block(3, 3, 3, 0.1, solid(2e4, 0.3));
  for (const TimeScheme scheme : {TimeScheme::kEuler, TimeScheme::kBdf2})
    for (const SolverMode mode : {SolverMode::kQuasi, SolverMode::kNewton}) {
      scene.scheme = scheme;
      const double lost = momentum_lost(scene, {.mode = mode, .tolerance = 1e-2},
                                        {.velocity = {0.1, -0.2, 0.3}, .spin = {3, 4, 5}}, 100);
      EXPECT_LT(lost, 1e-13) << int(scheme) << ' ' << int(mode);
    }
}

TEST(Dynamics, FreeFallIsExact) {
  // E8: g t (t + dt)/2 for implicit Euler
  for (const SolverMode mode : {SolverMode::kQuasi, SolverMode::kNewton}) {
    Scene scene = free_block(4, 3, 2, 0.1, solid(1e5, 0.4));
    scene.gravity = {0, -9.81, 0};
    finish_scene(scene);
    Solver solver(scene, {.mode = mode});
    State state = initial_state(scene);
    const int steps = 30;
    for (int k = 0; k < steps; ++k) ASSERT_TRUE(solver.step(state).converged);
    const double t = steps * scene.dt, fall = 9.81 / 2 * t * (t + scene.dt);
    for (int64_t n = 0; n < scene.grid.node_count(); ++n) {
      ASSERT_NEAR(scene.grid.rest(n, 1) - state.x(n, 1), fall, 1e-12 * fall);
      ASSERT_NEAR(state.x(n, 0), scene.grid.rest(n, 0), 1e-12);
    }
  }
}

TEST(Dynamics, SpinLosesWhatImplicitEulerPredictsForARigidBody) {
  // E6: a rigid body in implicit Euler turns by theta' with tan theta' = sin theta / (2 - cos
  // theta), the first step by atan(omega dt); its angular momentum is proportional to sin theta
  const double h = 0.05, dt = 1.0 / 60, omega = 0.2 / dt;
  for (const Hourglass hourglass : {Hourglass::kVariance, Hourglass::kFull}) {
    Scene scene = scene_on(make_box(6, 6, 3, h), solid(young_of_courant(40, h, dt), 0.3));
    scene.hourglass = hourglass;
    finish_scene(scene);
    Solver solver(scene, {.tolerance = 1e-5});
    State state = initial_state(scene, {.spin = {0, 0, omega}});
    const double centre[2] = {3 * h, 3 * h}, start = spin_momentum(scene, state, centre);
    const int steps = 20;
    double theta = std::atan(omega * dt);
    for (int k = 0; k < steps; ++k) {
      ASSERT_TRUE(solver.step(state).converged);
      if (k > 0) theta = std::atan(std::sin(theta) / (2 - std::cos(theta)));
    }
    const double kept = spin_momentum(scene, state, centre) / start;
    const double predicted = std::sin(theta) / (omega * dt);
    printf(
        "angular momentum kept over %d steps of 0.2 rad: %.4f, predicted for a rigid body %.4f\n",
        steps, kept, predicted);
    EXPECT_NEAR(kept, predicted, 0.01 * (1 - predicted));
  }
}

/// Energy after each step of a run with its start.
std::vector<double> energies(const Scene& scene, State state, int steps, double tolerance) {
  Solver solver(scene, {.tolerance = tolerance});
  std::vector<double> result;
  for (int k = 0; k < steps; ++k) {
    const StepReport report = solver.step(state);
    EXPECT_TRUE(report.converged);
    const EnergyParts& e = report.energy;
    result.push_back(e.kinetic + e.elastic + e.hourglass + e.gravity + e.contact);
  }
  return result;
}

TEST(Dynamics, EnergyNeverRisesInImplicitEuler) {
  // E7: a beam falls from rest and swings, and a free twisted block spins
  for (const Hourglass hourglass : {Hourglass::kFull, Hourglass::kVariance, Hourglass::kOff}) {
    Scene beam = clamped_beam(12, 3, 3, 0.05, solid(5e4, 0.3));
    beam.hourglass = hourglass;
    finish_scene(beam);
    Scene block = free_block(8, 2, 2, 0.05, solid(1e5, 0.3));
    block.hourglass = hourglass;
    finish_scene(block);
    State twisted = initial_state(block, {.spin = {5.5, 0, 0}});
    for (int64_t n = 0; n < block.grid.node_count(); ++n) {
      const double angle = 2 * (block.grid.rest(n, 0) / 0.4 - 0.5);
      const double y = block.grid.rest(n, 1) - 0.05, z = block.grid.rest(n, 2) - 0.05;
      twisted.x(n, 1) = 0.05 + std::cos(angle) * y - std::sin(angle) * z;
      twisted.x(n, 2) = 0.05 + std::sin(angle) * y + std::cos(angle) * z;
    }
    const std::vector<double> runs[2] = {energies(beam, initial_state(beam), 90, 1e-5),
                                         energies(block, twisted, 60, 1e-5)};
    for (const std::vector<double>& energy : runs) {
      const double scale = std::abs(energy.front() - energy.back());
      EXPECT_GT(scale, 0);
      double rise = 0;
      for (size_t k = 1; k < energy.size(); ++k) rise = std::max(rise, energy[k] - energy[k - 1]);
      EXPECT_LT(rise, 1e-6 * scale) << "hourglass " << int(hourglass);
    }
  }
}

TEST(Dynamics, EnergyNeverRisesInImplicitEulerForAnyLaw) {
  // E7: the beam of above under each law, fallen far beyond small strains
  for (const Law law :
       {Law::kFixedCorotated, Law::kNeoHookean, Law::kStableNeoHookean, Law::kStvk, Law::kHencky}) {
    const Scene beam = clamped_beam(12, 3, 3, 0.05, solid(3e4, 0.4, law));
    const std::vector<double> energy = energies(beam, initial_state(beam), 60, 1e-5);
    const double scale = std::abs(energy.front() - energy.back());
    double rise = 0;
    for (size_t k = 1; k < energy.size(); ++k) rise = std::max(rise, energy[k] - energy[k - 1]);
    EXPECT_GT(scale, 0);
    EXPECT_LT(rise, 1e-6 * scale) << law_name(law);
  }
}

/// Kinetic and elastic energy of small displacements u and velocities v.
double linear_energy(const Scene& scene, IncrementalPotential& potential,
                     const std::vector<double>& u, const std::vector<double>& v) {
  std::vector<double> Au(u.size());
  potential.rest_hessian_product(u.data(), Au.data());
  double sum = dot(u, Au) / 2;
  for (size_t k = 0; k < u.size(); ++k)
    if (const int64_t n = int64_t(k / 3); !scene.pinned(n))
      sum += scene.mass(n) / 2 * v[k] * v[k] - potential.inertia(n) / 2 * u[k] * u[k];
  return sum;
}

TEST(Dynamics, Bdf2NeverRaisesTheGNormEnergyOfTheLinearProblem) {
  // E7: (E(y_n) + E(2 y_n - y_{n-1}))/4 of y = (u, v), small random motion over all frequencies
  Scene scene = scene_on(make_box(6, 3, 3, 0.1), solid(1e5, 0.3));
  pin_below(scene, 0, 0.05);
  scene.scheme = TimeScheme::kBdf2;
  scene.dt = 0.3 * 0.1 / std::sqrt(1e5 / 1000);
  finish_scene(scene);
  State state = initial_state(scene);
  const std::vector<double> start = random_field(scene, 1e-8, 51);
  for (size_t k = 0; k < start.size(); ++k) state.x.data()[k] += start[k];
  IncrementalPotential potential(scene);
  potential.begin_step(initial_state(scene), {TimeScheme::kEuler, scene.dt, 1});
  Solver solver(scene, {.mode = SolverMode::kNewton, .tolerance = 1e-9});
  double before = 0, first = 0, rise = -1e300;
  for (int k = 0; k < 300; ++k) {
    const std::vector<double> u0 = displacement(scene, state);
    const Array<double> v0 = state.v;
    ASSERT_TRUE(solver.step(state).converged);
    const std::vector<double> u = displacement(scene, state);
    std::vector<double> v(u.size()), u2(u.size()), v2(u.size());
    for (size_t i = 0; i < u.size(); ++i) {
      v[i] = state.v.data()[i];
      u2[i] = 2 * u[i] - u0[i], v2[i] = 2 * v[i] - v0.data()[i];
    }
    const double energy =
        (linear_energy(scene, potential, u, v) + linear_energy(scene, potential, u2, v2)) / 4;
    if (k == 0)
      first = energy;
    else
      rise = std::max(rise, energy - before);
    before = energy;
  }
  printf("BDF2: G-norm energy kept %.3f, largest change of a step %.1e of it\n", before / first,
         rise / first);
  EXPECT_LT(rise, 1e-9 * first);
  EXPECT_LT(before, first);
}

/// Displacement at a fixed time with a given number of steps.
std::vector<double> displacement_at(TimeScheme scheme, int steps, double time) {
  Scene scene = scene_on(make_box(5, 2, 2, 0.1), solid(2e4, 0.3));
  pin_below(scene, 0, 0.05);
  scene.gravity = {0, -9.81, 3};
  scene.hourglass = Hourglass::kVariance;
  scene.scheme = scheme;
  scene.dt = time / steps;
  finish_scene(scene);
  Solver solver(scene, {.tolerance = 1e-6});
  State state = initial_state(scene);
  for (int k = 0; k < steps; ++k) EXPECT_TRUE(solver.step(state).converged);
  return displacement(scene, state);
}

TEST(Dynamics, EulerIsOfFirstOrderAndBdf2OfSecond) {
  const double time = 0.2;
  const std::vector<double> exact = displacement_at(TimeScheme::kBdf2, 1600, time);
  for (const TimeScheme scheme : {TimeScheme::kEuler, TimeScheme::kBdf2}) {
    const double coarse = relative_difference(displacement_at(scheme, 40, time), exact);
    const double fine = relative_difference(displacement_at(scheme, 80, time), exact);
    const double order = std::log2(coarse / fine);
    printf("%s: error %.2e, %.2e, order %.2f\n", scheme == TimeScheme::kEuler ? "Euler" : "BDF2",
           coarse, fine, order);
    EXPECT_NEAR(order, scheme == TimeScheme::kEuler ? 1 : 2, 0.15);
  }
}

TEST(Dynamics, AVibrationKeepsTheAmplitudeOfItsScheme) {
  // E2: stretching along x of one free voxel, nu = 0: omega^2 = 4 E / (rho h^2) for the mode
  // u = q s_x; small, so that it is linear
  const double h = 0.1, young = 1e5, omega = std::sqrt(4 * young / (1000 * h * h));
  for (const TimeScheme scheme : {TimeScheme::kEuler, TimeScheme::kBdf2}) {
    Scene scene = scene_on(make_box(1, 1, 1, h), solid(young, 0, Law::kStvk));
    scene.scheme = scheme;
    scene.dt = 0.1 / omega;
    finish_scene(scene);
    Solver solver(scene, {.tolerance = 1e-9});
    State state = initial_state(scene);
    const double size = 1e-6 * h;
    for (int64_t n = 0; n < 8; ++n) state.x(n, 0) += size * (scene.grid.node_coord(n, 0) ? 1 : -1);
    // crossings of zero give the period, kinetic plus elastic energy the amplitude
    const auto mode = [&] { return displacement(scene, state)[0]; };
    std::vector<double> zero, square;
    double before = mode();
    for (int k = 1; zero.size() < 7; ++k) {
      const StepReport report = solver.step(state);
      ASSERT_TRUE(report.converged);
      const double now = mode();
      if (before * now <= 0) {
        zero.push_back(k - now / (now - before));
        square.push_back(report.energy.kinetic + report.energy.elastic);
      }
      before = now;
    }
    // three periods between the first and the last crossing
    const double frequency = 3 * 2 * M_PI / (zero[6] - zero[0]) / 0.1;
    const double kept = std::pow(square[6] / square[0], 1.0 / 6);
    printf("%s: frequency %.4f of omega, amplitude kept per period %.4f\n",
           scheme == TimeScheme::kEuler ? "Euler" : "BDF2", frequency, kept);
    EXPECT_NEAR(frequency, scheme == TimeScheme::kEuler ? 0.99669 : 0.99671, 1e-3);
    EXPECT_NEAR(kept, scheme == TimeScheme::kEuler ? 0.731 : 0.9985,
                scheme == TimeScheme::kEuler ? 0.02 : 1e-3);
  }
}

}  // namespace
}  // namespace elastogen::test
