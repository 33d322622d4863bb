// SPDX-License-Identifier: Apache-2.0
// The network on the device against the CPU, on the same numbers. Nothing is here in builds without
// CUDA; skipped where there is no device.

#ifdef ELASTOGEN_CUDA

#include "core/error.hpp"
#include "network/solver.hpp"
#include "network/step/quasi_solver.hpp"
#include "tests/network/device_memory.hpp"
#include "tests/network/device_support.hpp"
#include "tests/network/potential/device_potential_support.hpp"
#include "tests/support/laws.hpp"

namespace elastogen::test {
namespace {

constexpr double kH = kRaggedEdge;

TEST_F(OnCard, EnergyAndGradientOfEveryLawAndHourglassTerm) {
  for (const Law law : kLaws)
    for (const Hourglass hourglass : {Hourglass::kFull, Hourglass::kVariance, Hourglass::kOff}) {
      SCOPED_TRACE(concat(law_name(law), " hourglass ", int(hourglass)));
      const Scene scene = ragged(law, hourglass);
      const std::vector<double> now = bent(scene, 0.02 * kH, 5), u = bent(scene, 0.03 * kH, 6);
      IncrementalPotential host(scene);
      host.begin_step(state_at(scene, now), {TimeScheme::kEuler, scene.dt, 1});
      cuda::DevicePotential device(host);
      device.begin_step(host);
      expect_like_host<double>(host, device, u, 1e-12);
      expect_like_host<float>(host, device, u, 2e-5);
    }
}

TEST_F(OnCard, EnergyAndGradientOfNetsByTheirTables) {
  const Scene scene = ragged(Law::kNeoHookean);
  for (const double shake : {0.03, 0.9}) {  // the second leaves the box of the nets
    const std::vector<double> now = bent(scene, 0.02 * kH, 5), u = bent(scene, shake * kH, 6);
    IncrementalPotential host(scene,
                              {shipped_net(Law::kNeoHookean, 0.4, Evaluation::kTable), nullptr});
    host.begin_step(state_at(scene, now), {TimeScheme::kBdf2, scene.dt, 2.25});
    cuda::DevicePotential device(host);
    device.begin_step(host);
    expect_like_host<double>(host, device, u, 1e-12);
  }
}

TEST_F(OnCard, HessianOfEveryLawAndHourglassTerm) {
  for (const Law law : kLaws)
    for (const Hourglass hourglass : {Hourglass::kFull, Hourglass::kVariance, Hourglass::kOff}) {
      SCOPED_TRACE(concat(law_name(law), " hourglass ", int(hourglass)));
      const Scene scene = ragged(law, hourglass);
      const std::vector<double> now = bent(scene, 0.02 * kH, 5), u = bent(scene, 0.03 * kH, 6);
      IncrementalPotential host(scene);
      host.begin_step(state_at(scene, now), {TimeScheme::kEuler, scene.dt, 1});
      cuda::DevicePotential device(host);
      device.begin_step(host);
      expect_hessian_of_host(host, device, u, bent(scene, 0.5 * kH, 7));
    }
}

/// Where nothing is projected A p is the derivative of the gradient along p, in double but for the
/// tangents.
TEST_F(OnCard, HessianIsTheDerivativeOfTheGradientNearRest) {
  const Scene scene = ragged(Law::kNeoHookean);
  IncrementalPotential host(scene);
  host.begin_step(initial_state(scene), {TimeScheme::kEuler, scene.dt, 1});
  cuda::DevicePotential device(host);
  device.begin_step(host);
  const std::vector<double> p = bent(scene, 0.5 * kH, 8);
  const std::vector<double> rest(p.size());
  OnDevice<double> place(rest), direction(p), product(rest);
  device.linearise(place.data());
  device.hessian_product(direction.data(), product.data());
  const double step = 1e-5;
  std::vector<double> ahead(p), behind(p), difference(p.size());
  for (size_t k = 0; k < p.size(); ++k) ahead[k] = step * p[k], behind[k] = -step * p[k];
  OnDevice<double> at_ahead(ahead), at_behind(behind), g_ahead(rest), g_behind(rest);
  device.evaluate<double>(at_ahead.data(), g_ahead.data());
  device.evaluate<double>(at_behind.data(), g_behind.data());
  const std::vector<double> a = g_ahead.host(), b = g_behind.host();
  for (size_t k = 0; k < p.size(); ++k) difference[k] = (a[k] - b[k]) / (2 * step);
  EXPECT_LT(relative_difference(product.host(), difference), 1e-6);
}

TEST_F(OnCard, HessianOfNetsByTheirTables) {
  const Scene scene = ragged(Law::kNeoHookean);
  IncrementalPotential host(scene,
                            {shipped_net(Law::kNeoHookean, 0.4, Evaluation::kTable), nullptr});
  const std::vector<double> now = bent(scene, 0.02 * kH, 5), u = bent(scene, 0.03 * kH, 6);
  host.begin_step(state_at(scene, now), {TimeScheme::kEuler, scene.dt, 1});
  cuda::DevicePotential device(host);
  device.begin_step(host);
  expect_hessian_of_host(host, device, u, bent(scene, 0.5 * kH, 7));
}

TEST_F(OnCard, NodalRotations) {
  const Scene scene = ragged(Law::kNeoHookean);
  const std::vector<double> u = bent(scene, 0.05 * kH, 6);
  IncrementalPotential host(scene);
  host.begin_step(state_at(scene, u), {TimeScheme::kEuler, scene.dt, 1});
  host.set_nodal_rotations(u.data());
  cuda::DevicePotential device(host);
  device.begin_step(host);
  OnDevice<double> place(u);
  device.set_nodal_rotations(place.data());
  std::vector<Quaternion<float>> turns(u.size() / 3);
  ASSERT_EQ(cudaMemcpy(turns.data(), device.nodal_rotation(), turns.size() * sizeof(turns[0]),
                       cudaMemcpyDeviceToHost),
            cudaSuccess);
  std::vector<float> found;
  for (const Quaternion<float>& turn : turns) {
    const Mat3<float> R = rotation_matrix(turn);
    found.insert(found.end(), R.m, R.m + 9);
  }
  EXPECT_LT(relative_difference(found, host.nodal_rotation()), 1e-5);
}

/// Host and device on one scene, at the start of a step.
struct Pair {
  Pair(const Scene& scene, const std::vector<double>& now, bool with_encoder)
      : state(state_at(scene, now)), potential(scene) {
    potential.begin_step(state, {TimeScheme::kEuler, scene.dt, 1});
    potential.set_nodal_rotations(now.data());
    first.emplace(potential, EncoderChoice{with_encoder}, cuda::kDenseNodes);
    device.emplace(potential, EncoderChoice{with_encoder});
    device->begin_step(potential);
    device->set_nodal_rotations(now.data());
  }
  State state;
  IncrementalPotential potential;
  std::optional<Preconditioner<float>> first;
  std::optional<cuda::DeviceQuasi> device;
};

TEST_F(OnCard, Preconditioner) {
  Scene ball = scene_on(ball_grid(0.2, 0.02), solid(5e4, 0.3));  // nothing pinned
  ball.gravity = {0, -9.81, 0};
  finish_scene(ball);
  const Scene scenes[] = {ragged(Law::kNeoHookean), ball,
                          clamped_beam(40, 9, 17, kH, solid(1e5, 0.45)),
                          clamped_beam(3, 2, 2, kH, solid(1e5, 0.3))};  // one level, a dense one
  for (const Scene& scene : scenes)
    for (const bool with_encoder : {false, true}) {
      SCOPED_TRACE(concat(scene.grid.voxel_count(), " voxels, encoder ", with_encoder));
      Pair pair(scene, bent(scene, 0.02 * kH, 5), with_encoder);
      // one vector in both precisions
      const std::vector<double> r = random_field(scene, 1, 9);
      const std::vector<float> single(r.begin(), r.end());
      std::vector<double> z(r.size());
      std::vector<float> z_single(r.size());
      OnDevice<double> r_there(r), z_there(z);
      OnDevice<float> r_single_there(single), z_single_there(z_single);
      pair.first->apply(r.data(), z.data());
      pair.device->precondition(r_there.data(), z_there.data());
      // device and host agree in both
      EXPECT_LT(relative_difference(z_there.host(), z), 1e-5);
      pair.first->apply(single.data(), z_single.data());
      pair.device->precondition(r_single_there.data(), z_single_there.data());
      EXPECT_LT(relative_difference(z_single_there.host(), z_single), 1e-5);
    }
}

TEST_F(OnCard, IterationsEndWhereThoseOfTheHostEnd) {
  const Scene scene = clamped_beam(40, 9, 17, kH, solid(1e5, 0.4));
  // weight of the free nodes
  const std::vector<double> now(3 * size_t(scene.grid.node_count()));
  double force = 0;
  for (int64_t n = 0; n < scene.grid.node_count(); ++n)
    force += scene.pinned(n) ? 0 : scene.mass(n) * scene.mass(n);
  force = 9.81 * std::sqrt(force);
  const auto never = [] { return false; };
  constexpr double kAlways = std::numeric_limits<double>::infinity();
  struct Case {
    double tolerance, precise_below;  // both over the force
  };
  for (const auto [tolerance, precise_below] :
       {Case{1e-3, 0}, Case{1e-6, kAlways}, Case{1e-6, 1e-4}}) {
    SCOPED_TRACE(concat("tolerance ", tolerance, ", in double below ", precise_below));
    // the host, the device, and the device again
    Pair pair(scene, now, true);
    Zeroed<double> host = pair.potential.predictor(), device = host, again = host;
    std::vector<double> g(now);
    const bool single = precise_below == 0;
    const double target = tolerance * force;
    const IterationResult on_host =
        single
            ? QuasiSolver<float>(pair.potential).solve(host.data(), target, 200, *pair.first, never)
            : QuasiSolver<double>(pair.potential)
                  .solve(host.data(), target, 200, *pair.first, never);
    const IterationResult on_device =
        pair.device->solve(device.data(), target, 200, precise_below * force, never);
    pair.device->solve(again.data(), target, 200, precise_below * force, never);
    EXPECT_TRUE(on_host.converged);
    EXPECT_TRUE(on_device.converged);
    EXPECT_NEAR(on_device.outer, on_host.outer, 1 + on_host.outer / 10);
    EXPECT_EQ(device, again);  // the same bits
    pair.potential.residual(device.data(), g.data());
    EXPECT_LE(norm(g), 1.05 * target);  // by the host, in double
    EXPECT_LT(relative_difference(device, host), tolerance);
  }
}

TEST_F(OnCard, ResidualIsThatOfTheHost) {
  const Scene scene = ragged(Law::kNeoHookean);
  const std::vector<double> now = bent(scene, 0.02 * kH, 5), u = bent(scene, 0.03 * kH, 6);
  Pair pair(scene, now, false);
  std::vector<double> expected(u.size());
  const PotentialValue a = pair.potential.residual(u.data(), expected.data());
  OnDevice<double> place(u), gradient(now);
  pair.device->potential().start_residual(place.data(), gradient.data());
  EXPECT_LT(relative_difference(gradient.host(), expected), 1e-12);  // which waits for it
  const PotentialValue b = pair.device->potential().value();
  EXPECT_NEAR(b.min_corner_j, a.min_corner_j, 1e-12);
  EXPECT_NEAR(b.total(), a.total(), 1e-12 * a.total());
}

TEST_F(OnCard, AutoTakesItWhereItCan) {
  const Scene scene = ragged(Law::kNeoHookean);
  SolverOptions options;
  options.device = Device::kAuto;
  EXPECT_NE(Solver(scene, options).device(), "cpu");
  options.mode = SolverMode::kNewton;
  EXPECT_NE(Solver(scene, options).device(), "cpu");
  Scene touching = scene;
  touching.colliders = {half_space({0, 1, 0}, -1, 0.5)};
  touching.surface = face_points(scene.grid);
  EXPECT_NE(Solver(touching, options).device(), "cpu");
  touching.scheme = TimeScheme::kAuto;
  EXPECT_NE(Solver(touching, options).device(), "cpu");
  options.learned = {shipped_net(Law::kNeoHookean, 0.4, Evaluation::kNet), nullptr};
  EXPECT_NE(Solver(scene, options).device(), "cpu");
}

TEST_F(OnCard, AutoGoesOnWithoutItWhereThereIsNoRoom) {
  const Scene scene = clamped_beam(48, 24, 24, kH, solid(1e5, 0.3));
  SolverOptions options;
  {
    const AllMemory taken;
    options.device = Device::kCuda;
    try {
      Solver(scene, options);
      ADD_FAILURE() << "there was room";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kResources);
      const std::string text = error.what();
      EXPECT_NE(text.find("MiB of the card's memory"), std::string::npos) << text;
    }
    options.device = Device::kAuto;
    EXPECT_EQ(Solver(scene, options).device(), "cpu");
  }
  EXPECT_NE(Solver(scene, options).device(), "cpu");
}

size_t free_on_card() {
  size_t free = 0, total = 0;
  cudaMemGetInfo(&free, &total);
  return free;
}

/// Steps of a few voxels by both iterations, so that the kernels of larger scenes of the kind are
/// there, which take memory too.
void load_kernels(const Scene& of, SolverOptions options) {
  Scene scene = clamped_beam(8, 4, 4, kH, of.materials[0]);
  scene.scheme = of.scheme;
  scene.colliders = of.colliders;
  if (!scene.colliders.empty()) scene.surface = face_points(scene.grid);
  for (const SolverMode mode : {SolverMode::kQuasi, SolverMode::kNewton}) {
    options.mode = mode;
    Solver solver(scene, options);
    State state = initial_state(scene);
    solver.step(state);
  }
}

/// The message of a card that is full, against the memory that a step takes of an empty one.
void expect_memory_asked_for(const Scene& scene, const LearnedLaws& nets = {}) {
  SolverOptions options;
  options.learned = nets;
  options.device = Device::kCuda;
  load_kernels(scene, options);
  double asked = 0;
  {
    const AllMemory taken;
    try {
      Solver(scene, options);
    } catch (const Error& error) {
      std::sscanf(error.what(), "the scene needs %lf", &asked);
    }
  }
  const size_t before = free_on_card();
  Solver solver(scene, options);
  State state = initial_state(scene);
  solver.step(state);
  const double taken = double(before - free_on_card()) / (1 << 20);
  printf("asked for %.0f MiB, taken %.0f MiB\n", asked, taken);
  EXPECT_GE(asked, 0.97 * taken);  // kernels that are loaded late count as used
  EXPECT_LE(asked, 2 * taken);     // only one of the two iterations was made
}

TEST_F(OnCard, TheRoomThatIsAskedForIsWhatIsTaken) {
  Scene scene = clamped_beam(96, 48, 48, kH, solid(1e5, 0.3));
  expect_memory_asked_for(scene);
  expect_memory_asked_for(scene, {shipped_net(Law::kNeoHookean, 0.3, Evaluation::kNet)});
  scene.colliders = {half_space({0, 1, 0}, 0, 0.5)};
  scene.surface = face_points(scene.grid);
  expect_memory_asked_for(scene);
}

TEST_F(OnCard, TheRoomOfStagesThatIsAskedForIsWhatIsTaken) {
  // larger, as both iterations are made: the card rounds each of some 40 arrays up to 2 MiB
  Scene scene = clamped_beam(192, 72, 72, kH, solid(1e5, 0.3));
  scene.scheme = TimeScheme::kAuto;
  expect_memory_asked_for(scene);
  scene.colliders = {half_space({0, 1, 0}, 0, 0.5)};
  scene.surface = face_points(scene.grid);
  expect_memory_asked_for(scene);
}

}  // namespace
}  // namespace elastogen::test

#endif
