// SPDX-License-Identifier: Apache-2.0
// Steps on the device: their parts and whole runs against the CPU. Nothing is here in builds
// without CUDA; skipped where there is no device.

#ifdef ELASTOGEN_CUDA

#include "core/error.hpp"
#include "network/free_flight.hpp"
#include "network/predictor.hpp"
#include "network/solver.hpp"
#include "tests/network/device_support.hpp"

namespace elastogen::test {
namespace {

/// A state in motion: turned, shaken, with a step before where BDF2 needs one.
State in_motion(const Scene& scene) {
  const StartMotion motion{.velocity = {0.3, -0.2, 0.5}, .spin = {2, -1, 3}};
  State state = initial_state(scene, motion);
  const std::vector<double> shake = random_field(scene, 0.05 * scene.grid.h, 4);
  state.x_before = state.x, state.v_before = state.v;
  for (int64_t k = 0; k < state.x.size(); ++k) {
    state.x.data()[k] += scene.dt * state.v.data()[k] + shake[size_t(k)];
    state.v.data()[k] *= 1.1;
  }
  return state;
}

/// A step that is begun on the host and on the device.
struct Begun {
  explicit Begun(const Scene& s) : Begun(s, in_motion(s)) {}
  Begun(const Scene& s, const State& from)
      : scene(s), state(from), scheme(step_scheme(s, state)), potential(s), flight(s) {
    potential.begin_step(state, scheme);
    device = cuda::make_device_step(potential, EncoderChoice{});
    device->upload(state);
    device->begin_step(scheme, state.time);
  }
  std::vector<double> start() const {
    std::vector<double> u(potential.predictor().size());
    Predictor(scene).start(state, potential.predictor(), u.data());
    return u;
  }
  std::vector<double> device_u() const {
    std::vector<double> u(potential.predictor().size());
    device->download_u(u.data());
    return u;
  }
  /// The start of lowest Phi on the host, as Solver chooses it; keeps its order.
  std::vector<double> chosen_start() {
    std::vector<double> lowest = start(), other = lowest;
    for (int order = 1; order <= Predictor::orders(!state.x_before.empty()); ++order) {
      Predictor(scene).extrapolate(state, scheme, order, other.data());
      if (rough_phi(other) < rough_phi(lowest)) lowest = other, chosen_order = order;
    }
    return lowest;
  }
  double rough_phi(const std::vector<double>& u) {
    return potential.evaluate(u.data(), static_cast<float*>(nullptr)).total();
  }
  double phi(const std::vector<double>& u) {
    std::vector<double> gradient(u.size());
    return potential.evaluate<double>(u.data(), gradient.data()).total();
  }

  const Scene& scene;
  State state;
  StepScheme scheme;
  IncrementalPotential potential;
  FreeFlight flight;
  std::unique_ptr<cuda::DeviceStep> device;
  int chosen_order = 0;
};

double farthest(const std::vector<double>& a, const std::vector<double>& b) {
  double largest = 0;
  for (size_t k = 0; k < a.size(); ++k) largest = std::max(largest, std::abs(a[k] - b[k]));
  return largest;
}

std::vector<Scene> scenes() {
  std::vector<Scene> list;
  for (const TimeScheme scheme : {TimeScheme::kEuler, TimeScheme::kBdf2})
    for (const auto& make : {beam_of_regions, falling_bar, three_blocks})
      list.push_back(make(scheme));
  return list;
}

TEST_F(OnCard, StepStartsWhereThatOfTheHostStarts) {
  for (const Scene& scene : scenes()) {
    SCOPED_TRACE(concat(scene.grid.voxel_count(), " voxels, scheme ", int(scene.scheme)));
    Begun b(scene);
    const Zeroed<double>& of_now = b.potential.now();
    const std::vector<double> expected = b.start(), now(of_now.begin(), of_now.end());
    EXPECT_LT(relative_difference(b.device_u(), expected), 1e-12);
    const double way = farthest(expected, now);
    EXPECT_NEAR(b.device->farthest(), way, 1e-12 * way);
    EXPECT_NEAR(b.device->phi(), b.phi(expected), 1e-11 * b.phi(expected));
    EXPECT_NEAR(b.device->phi_now(), b.phi(now), 1e-11 * b.phi(now));
    b.device->choose_start();
    EXPECT_LT(relative_difference(b.device_u(), b.chosen_start()), 1e-12);
    b.device->return_to_now();
    EXPECT_LT(relative_difference(b.device_u(), now), 1e-12);
    b.device->upload_u(expected.data());
    EXPECT_EQ(b.device->clear_start(), nullptr);
    EXPECT_EQ(b.device->is_below_clear_start(), b.rough_phi(expected) < b.rough_phi(now));
    b.device->return_to_clear_start();
    EXPECT_LT(relative_difference(b.device_u(), now), 1e-12);
  }
}

TEST_F(OnCard, StartsOfEachOrderAreTaken) {
  struct Case {
    TimeScheme scheme;
    double faster, before;  ///< factors of the velocities, and of those before to them
    int order;              ///< of the lowest start
  };
  for (const Case& c : {Case{TimeScheme::kBdf2, 20, 0.5, 0}, Case{TimeScheme::kEuler, 1, 0, 1},
                        Case{TimeScheme::kEuler, 20, -3, 2}}) {
    SCOPED_TRACE(concat("order ", c.order));
    const Scene scene = beam_of_regions(c.scheme);
    State state = in_motion(scene);
    for (int64_t k = 0; k < state.v.size(); ++k) {
      state.v.data()[k] *= c.faster;
      state.v_before.data()[k] = c.before * state.v.data()[k];
    }
    Begun b(scene, state);
    b.device->choose_start();
    EXPECT_LT(relative_difference(b.device_u(), b.chosen_start()), 1e-12);
    EXPECT_EQ(b.chosen_order, c.order);
  }
}

TEST_F(OnCard, StateComesBackAsItWent) {
  const Scene scene = three_blocks(TimeScheme::kBdf2);
  Begun b(scene);
  State read;
  EXPECT_TRUE(b.device->has_before());
  b.device->download(read, StateParts::kPositions);
  EXPECT_EQ(read.x, b.state.x);
  EXPECT_TRUE(read.v.empty());
  b.device->download(read, StateParts::kAll);
  EXPECT_EQ(read.v, b.state.v);
  EXPECT_EQ(read.x_before, b.state.x_before);
  EXPECT_EQ(read.v_before, b.state.v_before);
}

TEST_F(OnCard, StateOfSeveralChunksComesBackAsItWent) {
  // 5.4 MB an array, which go through two chunks of 2 MB by turns, the last of them in part
  const Scene scene = clamped_beam(60, 60, 60, 0.02, solid(1e5, 0.3));
  Begun b(scene);
  State read;
  for (int k = 0; k < 2; ++k) {
    b.device->download(read, StateParts::kAll);
    EXPECT_TRUE(read.x == b.state.x);
    EXPECT_TRUE(read.v == b.state.v);
    EXPECT_TRUE(read.x_before == b.state.x_before);
    EXPECT_TRUE(read.v_before == b.state.v_before);
    std::swap(b.state.x, b.state.x_before);
    b.device->upload(b.state);
  }
}

/// The end of a step by the host's arithmetic, as in Solver.
struct End {
  State state;
  MotionEnergy energy;
};

End end_on_host(Begun& b, std::vector<double> u) {
  const Scene& scene = b.scene;
  const Zeroed<double>& aim = b.potential.predictor();
  if (b.flight.exists())
    b.flight.match_means(u.data(), [&](size_t n, size_t d) { return aim[3 * n + d]; });
  State next = b.state;
  std::swap(next.x_before, next.x), std::swap(next.v_before, next.v);
  for (int64_t n = 0; n < scene.grid.node_count(); ++n)
    for (int d = 0; d < 3; ++d) {
      const double now = b.state.x(n, d);
      next.x(n, d) = scene.pinned(n) ? now : scene.grid.rest(n, d) + u[size_t(3 * n + d)];
      next.v(n, d) =
          scene.pinned(n) ? 0 : velocity_after(b.scheme, next.x(n, d), now, b.state.x_before(n, d));
    }
  if (b.flight.exists())
    b.flight.match_means(next.v.data(), [&](size_t n, size_t d) {
      const auto node = int64_t(n);
      return free_velocity(b.scheme, b.state.v(node, int(d)), b.state.v_before(node, int(d)),
                           scene.gravity[d]);
    });
  MotionEnergy energy;
  for (int64_t n = 0; n < scene.grid.node_count(); ++n)
    for (int d = 0; d < 3; ++d) {
      energy.kinetic += scene.mass(n) / 2 * next.v(n, d) * next.v(n, d);
      energy.gravity -= scene.mass(n) * scene.gravity[size_t(d)] * next.x(n, d);
    }
  return {next, energy};
}

TEST_F(OnCard, StepEndsAsThatOfTheHost) {
  for (const Scene& scene : scenes()) {
    SCOPED_TRACE(concat(scene.grid.voxel_count(), " voxels, scheme ", int(scene.scheme)));
    Begun b(scene);
    std::vector<double> u = b.start();
    const std::vector<double> shake = random_field(scene, 0.02 * scene.grid.h, 8);
    for (size_t k = 0; k < u.size(); ++k) u[k] += shake[k];
    b.device->upload_u(u.data());
    const Certificate found = b.device->certify(b.flight.exists());
    const MotionEnergy energy = b.device->finish();
    const End end = end_on_host(b, u);
    std::vector<double> expected(u.size()), gradient(u.size());
    const PotentialValue value =
        b.potential.residual(displacement(scene, end.state).data(), expected.data());
    b.device->download_gradient(gradient.data());
    EXPECT_TRUE(found.finite);
    EXPECT_LT(relative_difference(gradient, expected), 1e-11);
    EXPECT_NEAR(found.size, norm(expected), 1e-11 * found.size);
    EXPECT_NEAR(found.value.total(), value.total(), 1e-11 * value.total());
    EXPECT_NEAR(found.value.min_corner_j, value.min_corner_j, 1e-11);
    EXPECT_NEAR(energy.kinetic, end.energy.kinetic, 1e-11 * energy.kinetic);
    EXPECT_NEAR(energy.gravity, end.energy.gravity, 1e-11 * std::abs(energy.gravity));
    State read;
    b.device->download(read, StateParts::kAll);
    EXPECT_LT(relative_difference(read.x, end.state.x), 1e-14);
    EXPECT_LT(relative_difference(read.v, end.state.v), 1e-11);
    EXPECT_EQ(read.x_before, b.state.x);
    EXPECT_EQ(read.v_before, b.state.v);
  }
}

TEST_F(OnCard, DisplacementsThatAreNotFiniteAreSeen) {
  const Scene scene = beam_of_regions(TimeScheme::kEuler);
  Begun b(scene);
  std::vector<double> u = b.start();
  u.back() = NAN;
  b.device->upload_u(u.data());
  EXPECT_FALSE(b.device->certify(false).finite);
}

struct Outcome {
  State state;
  int converged = 0;
  std::vector<double> residual;
  StepReport report;
};

Outcome run_clip(const Scene& scene, SolverOptions options, Device device,
                 const StartMotion& motion, int steps) {
  options.device = device;
  Solver solver(scene, options);
  Outcome result;
  solver.begin(initial_state(scene, motion));
  for (int k = 0; k < steps; ++k) {
    result.report = solver.advance();
    result.converged += result.report.converged;
  }
  solver.read(result.state);
  const Span<const double> g = solver.residual();
  result.residual.assign(g.data, g.data + g.size());
  return result;
}

TEST_F(OnCard, RunsEndInTheStatesOfTheHost) {
  constexpr int kSteps = 24;
  const StartMotion spinning{.velocity = {0.5, 1, 0}, .spin = {2, 3, -1}};
  for (const Scene& scene : scenes()) {
    SCOPED_TRACE(concat(scene.grid.voxel_count(), " voxels, scheme ", int(scene.scheme)));
    const SolverOptions options{.mode = SolverMode::kQuasi, .tolerance = 1e-6};
    const Outcome a = run_clip(scene, options, Device::kCpu, spinning, kSteps);
    const Outcome b = run_clip(scene, options, Device::kCuda, spinning, kSteps);
    EXPECT_EQ(a.converged, kSteps);
    EXPECT_EQ(b.converged, kSteps);
    EXPECT_LT(distance_of_ways(scene, b.state, a.state), 1e-5);
    EXPECT_NEAR(b.report.energy.kinetic, a.report.energy.kinetic, 1e-4 * a.report.energy.kinetic);
    EXPECT_NEAR(b.report.energy.elastic, a.report.energy.elastic, 1e-3 * a.report.energy.elastic);
    EXPECT_NEAR(b.report.min_j, a.report.min_j, 1e-4);
    EXPECT_LE(norm(b.residual), 1e-6 * reference_force(scene));
    EXPECT_GT(norm(b.residual), 0);
  }
}

TEST_F(OnCard, RunsTakeTheIterationsOfTheHost) {
  for (const Scene& scene : scenes()) {
    const SolverOptions options{.mode = SolverMode::kQuasi};
    const Outcome a = run_clip(scene, options, Device::kCpu, {}, 6);
    const Outcome b = run_clip(scene, options, Device::kCuda, {}, 6);
    EXPECT_EQ(b.converged, 6);
    EXPECT_EQ(b.report.float64, a.report.float64);
    EXPECT_NEAR(b.report.inner, a.report.inner, 2 + a.report.inner / 5);
  }
}

TEST_F(OnCard, TablesOfManyChunksOfAnUploadArriveWhole) {
  // 33 MB of modes and 9 MB of rest positions
  constexpr double kEdge = 0.02;
  const Scene scene =
      clamped_beam(90, 70, 61, kEdge, solid(young_of_courant(8, kEdge, 1.0 / 60), 0.4));
  const SolverOptions options{.mode = SolverMode::kQuasi, .tolerance = 1e-5};
  const Outcome a = run_clip(scene, options, Device::kCpu, {}, 2);
  const Outcome b = run_clip(scene, options, Device::kCuda, {}, 2);
  EXPECT_EQ(a.converged, 2);
  EXPECT_EQ(b.converged, 2);
  EXPECT_NEAR(b.report.inner, a.report.inner, 2 + a.report.inner / 5);
  EXPECT_LT(distance_of_ways(scene, b.state, a.state), 1e-4);
}

TEST_F(OnCard, LongRunsRepeatToTheBit) {
  const Scene scene = three_blocks(TimeScheme::kBdf2);
  const SolverOptions options{.mode = SolverMode::kQuasi};
  const StartMotion spinning{.spin = {1, 2, 3}};
  const Outcome a = run_clip(scene, options, Device::kCuda, spinning, 200);
  const Outcome b = run_clip(scene, options, Device::kCuda, spinning, 200);
  EXPECT_GE(a.converged, 199);
  EXPECT_EQ(a.state.x, b.state.x);
  EXPECT_EQ(a.state.v, b.state.v);
  EXPECT_EQ(a.residual, b.residual);
}

TEST_F(OnCard, PiecesFallAsOneMassPointWhateverTheTolerance) {
  const Scene scene = falling_bar(TimeScheme::kEuler);
  const StartMotion spinning{.spin = {3, 4, 5}};
  constexpr int kSteps = 50;
  const Outcome r = run_clip(scene, {.mode = SolverMode::kQuasi, .tolerance = 0.1}, Device::kCuda,
                             spinning, kSteps);
  const State start = initial_state(scene, spinning);
  const double t = kSteps * scene.dt;
  double mass = 0;
  Vec3 moved = {}, gained = {};
  for (int64_t n = 0; n < scene.grid.node_count(); ++n) {
    mass += scene.mass(n);
    for (int d = 0; d < 3; ++d) {
      moved[size_t(d)] += scene.mass(n) * (r.state.x(n, d) - start.x(n, d));
      gained[size_t(d)] += scene.mass(n) * (r.state.v(n, d) - start.v(n, d));
    }
  }
  for (size_t d = 0; d < 3; ++d) {
    EXPECT_NEAR(moved[d], mass * scene.gravity[d] * t * (t + scene.dt) / 2, 1e-11 * mass);
    EXPECT_NEAR(gained[d], mass * scene.gravity[d] * t, 1e-11 * mass);
  }
}

TEST_F(OnCard, NewtonEndsInTheStatesOfTheHost) {
  constexpr int kSteps = 12;
  const StartMotion spinning{.velocity = {0.5, 1, 0}, .spin = {2, 3, -1}};
  for (const Scene& scene : scenes()) {
    SCOPED_TRACE(concat(scene.grid.voxel_count(), " voxels, scheme ", int(scene.scheme)));
    const SolverOptions options{.mode = SolverMode::kNewton, .tolerance = 1e-6};
    const Outcome a = run_clip(scene, options, Device::kCpu, spinning, kSteps);
    const Outcome b = run_clip(scene, options, Device::kCuda, spinning, kSteps);
    EXPECT_EQ(a.converged, kSteps);
    EXPECT_EQ(b.converged, kSteps);
    EXPECT_LT(distance_of_ways(scene, b.state, a.state), 1e-5);
    // the card solves larger levels of the V-cycle: its iterations are others, and not more
    EXPECT_NEAR(b.report.outer, a.report.outer, 2);
    EXPECT_LE(b.report.inner, 3 + a.report.inner + a.report.inner / 5);
  }
}

TEST_F(OnCard, NewtonRepeatsToTheBit) {
  const Scene scene = three_blocks(TimeScheme::kBdf2);
  const SolverOptions options{.mode = SolverMode::kNewton};
  const StartMotion spinning{.spin = {1, 2, 3}};
  const Outcome a = run_clip(scene, options, Device::kCuda, spinning, 40);
  const Outcome b = run_clip(scene, options, Device::kCuda, spinning, 40);
  EXPECT_GE(a.converged, 39);
  EXPECT_EQ(a.state.x, b.state.x);
  EXPECT_EQ(a.residual, b.residual);
}

TEST_F(OnCard, AutoTakesNewtonOfStiffScenesThere) {
  Scene scene = beam_of_regions(TimeScheme::kEuler);
  scene.materials[0].poisson = 0.49;
  finish_scene(scene);
  Solver solver(scene, {.device = Device::kAuto});
  EXPECT_EQ(solver.mode(), SolverMode::kNewton);
  EXPECT_NE(solver.device(), "cpu");
  State state = initial_state(scene);
  EXPECT_TRUE(solver.step(state).converged);
}

/// Few iterations are left to quasi, so that newton ends each step.
TEST_F(OnCard, NewtonTakesOverASingleStep) {
  const Scene scene = beam_of_regions(TimeScheme::kBdf2);
  SolverOptions options{.tolerance = 1e-9, .max_outer = 16};
  const Outcome a = run_clip(scene, options, Device::kCpu, {}, 1);
  const Outcome b = run_clip(scene, options, Device::kCuda, {}, 1);
  EXPECT_GT(a.report.outer, 16);  // those of quasi, and steps of newton
  EXPECT_GT(b.report.outer, 16);
  EXPECT_EQ(b.report.converged, a.report.converged);
  EXPECT_LT(distance_of_ways(scene, b.state, a.state), 1e-6);
}

/// A start that tears a body apart, and no iteration of quasi: newton begins at the state before.
TEST_F(OnCard, StepsThatCannotEndAtTheirStartRetreat) {
  const Scene scene = falling_bar(TimeScheme::kBdf2);
  State state = in_motion(scene);
  const std::vector<double> shake = random_field(scene, 0.5 * scene.grid.h, 3);
  for (size_t k = 0; k < shake.size(); ++k) state.x_before.data()[k] += shake[k];
  IncrementalPotential potential(scene);
  potential.begin_step(state, step_scheme(scene, state));
  const Zeroed<double>& now = potential.now();
  const SolverOptions options{.mode = SolverMode::kQuasi, .device = Device::kCuda, .max_outer = 0};
  const StepReport report = Solver(scene, options).step(state);
  EXPECT_EQ(report.outer, 1);  // of newton
  std::vector<double> gradient(now.size());
  const double before = potential.evaluate<double>(now.data(), gradient.data()).total();
  const PotentialValue end = potential.residual(displacement(scene, state).data(), gradient.data());
  EXPECT_LT(end.total(), before);
  EXPECT_NEAR(report.residual * reference_force(scene), norm(gradient), 1e-9 * norm(gradient));
}

}  // namespace
}  // namespace elastogen::test

#endif
