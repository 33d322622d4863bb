// SPDX-License-Identifier: Apache-2.0
// Contact on the device against that of the CPU: its parts on the same numbers, and whole runs.
// Nothing is here in builds without CUDA; skipped where there is no device.

#ifdef ELASTOGEN_CUDA

#include "network/contact/contact_device.hpp"

#include "core/error.hpp"
#include "network/solver.hpp"
#include "network/step/quasi_solver_device.hpp"
#include "tests/network/contact/contact_scenes.hpp"
#include "tests/network/device_numbers.hpp"
#include "tests/network/device_support.hpp"

namespace elastogen::test {
namespace {

using ContactOnCard = OnCard;
using cuda::DeviceContact;

/// Host and device in a step from a shaken state, and a displacement further on.
struct InTouch {
  explicit InTouch(const Scene& scene, bool with_encoder = true)
      : potential(scene), u(random_field(scene, 0.02 * kEdge, 3)) {
    State state = initial_state(scene);
    for (size_t k = 0; k < u.size(); ++k) state.x.data()[k] += u[k];
    state.time = 0.25;
    potential.begin_step(state, {TimeScheme::kEuler, scene.dt, 1});
    potential.set_nodal_rotations(u.data());
    first.emplace(potential, EncoderChoice{with_encoder});
    device.emplace(potential, EncoderChoice{with_encoder});
    device->begin_step(potential);
    const std::vector<double> away = random_field(scene, 0.02 * kEdge, 4);
    for (size_t k = 0; k < u.size(); ++k) u[k] += away[k];
    device->set_nodal_rotations(u.data());  // which leaves u there
    potential.set_nodal_rotations(u.data());
  }
  DeviceContact& contact() { return *device->potential().contact(); }

  IncrementalPotential potential;
  std::vector<double> u;
  std::optional<Preconditioner<float>> first;
  std::optional<cuda::DeviceQuasi> device;
};

template <class T>
void expect_force_of_host(InTouch& pair, double bound) {
  std::vector<double> expected(pair.u.size());
  const double energy = pair.potential.contact().evaluate(pair.u.data(), expected.data());
  ASSERT_GT(energy, 0);
  OnDevice<double> place(pair.u);
  OnDevice<T> gradient{std::vector<T>(pair.u.size())};
  pair.contact().start_evaluation(place.data(), gradient.data());
  EXPECT_LT(relative_difference(gradient.host(), expected), bound);
  EXPECT_NEAR(pair.contact().energy(), energy, 1e-12 * energy);
  const double deepest = pair.potential.contact().deepest_overlap(pair.u.data());
  EXPECT_NEAR(pair.contact().deepest_overlap(), deepest, 1e-12 * deepest);
}

TEST_F(ContactOnCard, EnergyAndForceAreThoseOfTheHost) {
  const Scene scene = box_in_touch();
  InTouch pair(scene);
  expect_force_of_host<double>(pair, 1e-12);
  expect_force_of_host<float>(pair, 1e-6);
}

TEST_F(ContactOnCard, EnergyIsInfiniteBehindAWallAndZeroAwayFromAll) {
  const Scene scene =
      box_scene(4, 4, 4, kEdge, {0, 0, 0}, solid(1e5, 0.3), {half_space({0, 1, 0}, 0, 0.5)});
  InTouch pair(scene);
  std::vector<double> start(pair.u.size()), below(start), above(start);
  for (size_t k = 1; k < start.size(); k += 3) below[k] = -kEdge, above[k] = start[k] = kEdge;
  OnDevice<double> from(start), behind(below), away(above);
  pair.contact().begin_step(from.data(), 0);
  pair.contact().start_evaluation(behind.data(), static_cast<double*>(nullptr));
  behind.host();  // waits
  EXPECT_EQ(pair.contact().energy(), std::numeric_limits<double>::infinity());
  OnDevice<float> gradient{std::vector<float>(start.size(), 7.f)};
  pair.contact().start_evaluation(away.data(), gradient.data());
  EXPECT_EQ(gradient.host(), std::vector<float>(start.size(), 7.f));
  EXPECT_EQ(pair.contact().energy(), 0);
  EXPECT_EQ(pair.contact().deepest_overlap(), 0);
}

TEST_F(ContactOnCard, StepsAreCutWhereTheHostCutsThem) {
  const Scene scene = box_in_touch();
  InTouch pair(scene);
  for (const double size : {1e-3 * kEdge, 0.3 * kEdge, 5 * kEdge}) {
    std::vector<double> end = random_field(scene, size, 11);
    for (size_t k = 0; k < end.size(); ++k) end[k] += pair.u[k];
    const double share = pair.potential.contact().longest_step(pair.u.data(), end.data());
    OnDevice<double> from(pair.u), to(end);
    pair.contact().cut_step(from.data(), to.data());
    const std::vector<double> found = to.host();
    EXPECT_NEAR(pair.contact().share(), share, 1e-12);
    for (size_t k = 0; k < end.size(); ++k) end[k] = pair.u[k] + share * (end[k] - pair.u[k]);
    EXPECT_LT(relative_difference(found, end), 1e-12);
  }
}

TEST_F(ContactOnCard, HessianProductIsThatOfTheHost) {
  const Scene scene = box_in_touch();
  InTouch pair(scene);
  const std::vector<double> direction = random_field(scene, 1, 12);
  const std::vector<float> p(direction.begin(), direction.end());
  std::vector<float> expected(p.size()), without(p.size());
  pair.potential.linearise(pair.u.data());
  pair.potential.hessian_product(p.data(), expected.data());
  OnDevice<double> place(pair.u);
  OnDevice<float> from(p), to{std::vector<float>(p.size(), 7.f)};
  cuda::DevicePotential& device = pair.device->potential();
  device.linearise(place.data());
  device.hessian_product(from.data(), to.data());
  EXPECT_LT(relative_difference(to.host(), expected), 2e-5);
  device.linearise(place.data(), TangentKind::kProjected, false);
  device.hessian_product(from.data(), to.data());
  EXPECT_GT(relative_difference(to.host(), expected), 1e-2);
}

/// The first matrix in contact against the host's, and without contact once more.
void expect_first_matrix_of_host(const Scene& scene, bool with_encoder) {
  SCOPED_TRACE(concat(scene.grid.voxel_count(), " voxels, encoder ", with_encoder));
  InTouch pair(scene, with_encoder);
  const std::vector<double> r = random_field(scene, 1, 9);
  std::vector<double> expected(r.size()), free(r.size());
  OnDevice<double> from(r), to(expected);
  pair.first->apply(r.data(), free.data());
  pair.potential.linearise_contact(pair.u.data());
  pair.first->update_contact();
  pair.first->apply(r.data(), expected.data());
  ASSERT_GT(relative_difference(free, expected), 1e-3);
  for (int pass = 0; pass < 3; ++pass) {  // the second and third are graphs
    pair.device->update_contact(true);
    pair.device->precondition(from.data(), to.data());
    EXPECT_LT(relative_difference(to.host(), expected), 2e-5);
    pair.device->update_contact(false);
    pair.device->precondition(from.data(), to.data());
    EXPECT_LT(relative_difference(to.host(), free), 2e-5);
  }
}

TEST_F(ContactOnCard, FirstMatrixIsThatOfTheHost) {
  for (const bool with_encoder : {false, true}) {
    expect_first_matrix_of_host(box_in_touch(), with_encoder);
    // one level, a dense one, of which the encoder has no piece
    expect_first_matrix_of_host(
        box_scene(3, 2, 2, kEdge, {0, 0, 0}, solid(1e5, 0.3), one_of_each()), with_encoder);
  }
}

TEST_F(ContactOnCard, FirstMatrixOfManyLevelsIsThatOfTheHost) {
  // levels of their own launches above those of the cluster
  const Scene scene = box_scene(90, 70, 61, kEdge, {0, 0, 0}, solid(1e5, 0.45), one_of_each());
  expect_first_matrix_of_host(scene, true);
}

/// Results of a run.
struct ContactRun {
  State state;
  int converged = 0, outer = 0, inner = 0;
  double deepest = 0;
  StepReport last;
};

ContactRun run_in_contact(const Scene& scene, SolverOptions options, Device device,
                          const StartMotion& motion, int steps) {
  options.device = device;
  Solver solver(scene, options);
  EXPECT_EQ(solver.device() == "cpu", device == Device::kCpu);
  ContactRun run;
  solver.begin(initial_state(scene, motion));
  for (int k = 0; k < steps; ++k) {
    run.last = solver.advance();
    EXPECT_TRUE(run.last.finite) << run.last.refusal;
    run.converged += run.last.converged;
    run.outer += run.last.outer, run.inner += run.last.inner;
    run.deepest = std::max(run.deepest, run.last.deepest_overlap);
  }
  solver.read(run.state);
  return run;
}

struct ContactCase {
  const char* name;
  Scene scene;
  StartMotion motion;
};

/// A body that falls on a floor and slides, one that falls on a ball and off it, a clamped beam
/// on a lift, a body that a block pushes from step to step by more than the layer.
std::vector<ContactCase> contact_cases(TimeScheme scheme) {
  std::vector<ContactCase> list;
  const double h = 0.025;
  const Material soft = solid(young_of_courant(6.7, h, 1.0 / 60), 0.4);
  list.push_back({"floor",
                  box_scene(20, 5, 5, h, {0, 0, 0}, soft, {half_space({0, 1, 0}, -h, 0.3)}),
                  {.velocity = {0.3, -1, 0}, .spin = {0, 0, 0.5}}});
  list.push_back({"ball",
                  box_scene(8, 6, 8, h, {0, 0, 0}, soft, {ball({0.12, -0.42, 0.1}, 0.4)}),
                  {.velocity = {0, -0.5, 0}}});
  // pushed from below or from the side by blocks that move
  Collider lift = block({14 * h, -4.2 * h, 2.5 * h}, {8 * h, 4 * h, 1});
  lift.path = {{0, {}}, {0.3, {0, h, 0}}};
  Scene clamped = box_scene(20, 5, 5, h, {0, 0, 0}, soft, {lift});
  pin_below(clamped, 0, h / 2);
  list.push_back({"lift", clamped, {}});
  Collider pusher = block({-0.2, 2.5 * h, 2.5 * h}, {0.2, 0.5, 0.5});
  pusher.path = {{0, {}}, {1, {1.2, 0, 0}}};
  list.push_back({"pusher",
                  box_scene(8, 5, 5, h, {0, 0, 0}, soft, {half_space({0, 1, 0}, 0, 0.5), pusher}),
                  {}});
  // all with one scheme
  for (ContactCase& c : list) {
    c.scene.scheme = scheme;
    finish_scene(c.scene);
  }
  return list;
}

/// Runs of some steps on both, at a tolerance at which they end in the same states.
void expect_runs_of_host(SolverMode mode) {
  constexpr int kSteps = 24;
  for (const TimeScheme scheme : {TimeScheme::kEuler, TimeScheme::kBdf2})
    for (const ContactCase& c : contact_cases(scheme)) {
      SCOPED_TRACE(concat(c.name, ", scheme ", int(scheme)));
      const SolverOptions options{.mode = mode, .tolerance = 1e-6};
      const ContactRun a = run_in_contact(c.scene, options, Device::kCpu, c.motion, kSteps);
      const ContactRun b = run_in_contact(c.scene, options, Device::kCuda, c.motion, kSteps);
      const double apart = distance_of_ways(c.scene, b.state, a.state);
      printf("%s: outer %d and %d, inner %d and %d, apart %.1e, deepest %.4f\n", c.name, a.outer,
             b.outer, a.inner, b.inner, apart, b.deepest);
      EXPECT_EQ(b.converged, a.converged);
      EXPECT_GT(a.deepest, 0);
      EXPECT_LT(b.deepest, 0.25);
      EXPECT_NEAR(b.deepest, a.deepest, 1e-3);
      EXPECT_NEAR(b.inner, a.inner, 3 + a.inner / 10);
      EXPECT_LT(apart, 1e-5);
    }
}

TEST_F(ContactOnCard, QuasiEndsInTheStatesOfTheHost) {
  expect_runs_of_host(SolverMode::kQuasi);
}

TEST_F(ContactOnCard, NewtonEndsInTheStatesOfTheHost) {
  expect_runs_of_host(SolverMode::kNewton);
}

TEST_F(ContactOnCard, AutoTakesTheIterationsOfTheHost) {
  for (const ContactCase& c : contact_cases(TimeScheme::kEuler)) {
    SCOPED_TRACE(c.name);
    const ContactRun a = run_in_contact(c.scene, {}, Device::kCpu, c.motion, 12);
    const ContactRun b = run_in_contact(c.scene, {}, Device::kCuda, c.motion, 12);
    EXPECT_EQ(b.converged, a.converged);
    EXPECT_NEAR(b.inner, a.inner, 3 + a.inner / 10);
  }
}

TEST_F(ContactOnCard, RunsRepeatToTheBit) {
  for (const SolverMode mode : {SolverMode::kQuasi, SolverMode::kNewton})
    for (const ContactCase& c : contact_cases(TimeScheme::kBdf2)) {
      SCOPED_TRACE(c.name);
      const ContactRun a = run_in_contact(c.scene, {.mode = mode}, Device::kCuda, c.motion, 24);
      const ContactRun b = run_in_contact(c.scene, {.mode = mode}, Device::kCuda, c.motion, 24);
      EXPECT_EQ(a.state.x, b.state.x);
      EXPECT_EQ(a.state.v, b.state.v);
      EXPECT_EQ(a.inner, b.inner);
    }
}

/// Mean velocity of a clip's state.
Vec3 mean_velocity_of(const Scene& scene, const Solver& solver) {
  State state;
  solver.read(state);
  double mass = 0;
  Vec3 sum = {};
  for (int64_t n = 0; n < scene.grid.node_count(); ++n) {
    mass += scene.mass(n);
    for (size_t d = 0; d < 3; ++d) sum[d] += scene.mass(n) * state.v(n, int(d));
  }
  return scaled(sum, 1 / mass);
}

/// Thrown up by a floor without friction that stops.
TEST_F(ContactOnCard, AFreeBodyFliesAsItsMassDoesOnceItHasLeft) {
  // a floor that throws the body up and stops
  const double h = 0.025, speed = 2;
  Collider floor = half_space({0, 1, 0}, 0, 0);
  floor.path = {{0, {}}, {0.1, {0, 0.1 * speed, 0}}};
  const Scene scene =
      box_scene(6, 6, 6, h, {0, 0, 0}, solid(young_of_courant(6.7, h, 1.0 / 60), 0.3), {floor});
  Solver solver(scene, {.device = Device::kCuda});
  solver.begin(initial_state(scene, {.velocity = {0.25, 0, 0}}));
  Vec3 before = {};
  int pushed = 0, flown = 0;
  // while it is pushed, then in flight, where only gravity acts
  for (int k = 0; k < 16; ++k) {
    const StepReport report = solver.advance();
    ASSERT_TRUE(report.converged) << k;
    const Vec3 now = mean_velocity_of(scene, solver);
    const bool in_flight = report.energy.contact == 0;
    (in_flight ? flown : pushed) += 1;
    EXPECT_NEAR(now[0], 0.25, 1e-3);
    if (in_flight) {
      EXPECT_NEAR(now[1] - before[1], -9.81 * scene.dt, 1e-10);
    }
    before = now;
  }
  EXPECT_GE(pushed, 5);
  EXPECT_GE(flown, 5);
}

TEST_F(ContactOnCard, ACarriedStartIsThatOfTheHost) {
  const double h = 0.05;
  Collider lift = half_space({0, 1, 0}, 0, 0.5), obstacle = half_space({1, 0, 0}, 0, 0.5);
  lift.path = {{0, {}}, {1.0 / 60, {0, 0.3 * h, 0}}};
  const Scene scene = box_scene(3, 6, 3, h, {0, 0, 0}, solid(1e6, 0.3), {obstacle, lift});
  IncrementalPotential potential(scene);
  cuda::DevicePotential device(potential);
  Contact& host = potential.contact();
  const std::vector<double> now(3 * size_t(scene.grid.node_count()));
  std::vector<double> expected = now, end = random_field(scene, 2 * h, 6), cut = end;
  host.begin_step(now.data());
  host.carry(expected.data());
  ASSERT_EQ(host.obstacle(expected.data()), nullptr);
  const double share = host.longest_step(expected.data(), end.data());
  for (size_t k = 0; k < cut.size(); ++k) cut[k] = expected[k] + share * (end[k] - expected[k]);
  OnDevice<double> from(now), clear(now), u(end);
  device.contact()->begin_step(from.data(), 0);
  EXPECT_EQ(device.contact()->clear_start(from.data(), clear.data(), u.data(), device.held()),
            nullptr);
  EXPECT_LT(relative_difference(clear.host(), expected), 1e-12);
  EXPECT_LT(relative_difference(u.host(), cut), 1e-12);
  EXPECT_GT(norm(expected), 0);
}

TEST_F(ContactOnCard, APinnedPartInTheWayIsRefusedByName) {
  const double h = 0.05;
  Collider press = half_space({0, 1, 0}, 0, 0.5);
  press.name = "press";
  press.path = {{1.0 / 60, {}}, {2.0 / 60, {0, h, 0}}};
  Scene scene =
      box_scene(3, 3, 3, h, {0, 0, 0}, solid(1e6, 0.3), {half_space({1, 0, 0}, -1, 0.5), press});
  pin_below(scene, 1, h / 2);
  finish_scene(scene);
  Solver solver(scene, {.device = Device::kCuda});
  State state = initial_state(scene);
  ASSERT_TRUE(solver.step(state).finite);
  const Array<double> before = state.x;
  const StepReport report = solver.step(state);
  EXPECT_FALSE(report.finite);
  EXPECT_NE(report.refusal.find("'press'"), std::string::npos) << report.refusal;
  EXPECT_EQ(state.x, before);
}

TEST_F(ContactOnCard, NothingTunnelsAtTenKilometresASecond) {
  const double h = 0.05;
  const std::vector<Collider> targets = {half_space({0, 1, 0}, -h, 0.3),
                                         ball({0.1, -0.5 - h, 0.1}, 0.5),
                                         block({0.1, -0.001 - h, 0.1}, {100, 0.001, 100})};
  for (const Collider& target : targets)
    for (const SolverMode mode : {SolverMode::kQuasi, SolverMode::kNewton}) {
      const Scene scene = box_scene(4, 4, 4, h, {0, 0, 0}, solid(1e6, 0.3), {target});
      run_in_contact(scene, {.mode = mode, .max_outer = 40}, Device::kCuda,
                     {.velocity = {0, -1e4, 0}}, 4);
    }
}

}  // namespace
}  // namespace elastogen::test

#endif
