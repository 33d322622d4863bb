// SPDX-License-Identifier: Apache-2.0
// The parts of steps of stages on the device against those on the host, at displacements that both are
// given. Nothing is here in builds without CUDA; skipped where there is no device.

#ifdef ELASTOGEN_CUDA

#include "core/error.hpp"
#include "network/step/step_work.hpp"
#include "tests/network/held_bodies.hpp"
#include "tests/network/step/hung_scenes.hpp"
#include "tests/network/step/motion_machines.hpp"
#include "tests/network/step/moving_scenes.hpp"

namespace elastogen::test {
namespace {

/// What a machine says of a stage.
struct StageSaid {
  std::vector<std::vector<double>> starts;  // displacements
  std::vector<double> phi, gradient;
  double farthest = 0;
  bool rubs = false;
  Certificate certificate;
};

/// What it says of a step, and the state after it.
struct StepSaid {
  std::vector<StageSaid> stages;
  StageEnd end;
  MotionEnergy energy;
  double least = 0;
  State state;
};

std::vector<TimeStage> stages_of(TimeScheme kind, double h, double h_before) {
  if (kind == TimeScheme::kEuler) return {euler_stage(h)};
  if (kind == TimeScheme::kBdf2) return {bdf2_stage(h, h_before)};
  return {sdirk2_stage(0, h), sdirk2_stage(1, h)};
}

/// A stage that ends at its start plus a known field.
StageSaid make_stage(StepWork& work, const Scene& scene, const StepScheme& scheme, double time) {
  StageSaid said;
  std::vector<double> u(size_t(scene.grid.rest.size()));
  work.begin_step(scheme, time);
  said.phi.resize(scheme.stage.t_b != 0 ? 3 : 2);
  work.evaluate_starts(int(said.phi.size()), said.phi.data());
  for (const size_t start : {size_t(0), said.phi.size() - 1}) {
    work.use_start(int(start));
    work.download_u(u.data());
    said.starts.push_back(u);
  }
  said.farthest = work.farthest();
  EXPECT_EQ(work.clear_start(), nullptr);
  work.set_nodal_rotations();
  // the end, with friction of the positions there
  u = said.starts[0];
  const std::vector<double> more = random_field(scene, 2e-3 * scene.grid.h, 5);
  for (size_t k = 0; k < u.size(); ++k) {
    const bool held =
        scene.pinned(int64_t(k / 3)) || (!scene.fixed.empty() && scene.fixed.data()[k] >= 0);
    u[k] += held ? 0 : more[k];
  }
  work.upload_u(u.data());
  work.certify();
  said.rubs = work.renew_lags();
  said.certificate = work.certify();
  said.gradient.resize(u.size());
  work.download_gradient(said.gradient.data());
  return said;
}

/// A step from the present state of a machine.
StepSaid make_step(StepWork& work, const Scene& scene, TimeScheme kind, double h, double h_before,
                   double time) {
  StepSaid said;
  said.least = work.least_motion(scene.dt);
  const std::vector<TimeStage> stages = stages_of(kind, h, h_before);
  for (size_t s = 0; s < stages.size(); ++s) {
    if (s > 0) work.keep_stage();
    said.stages.push_back(make_stage(work, scene, StepScheme(kind, stages[s]), time));
  }
  const TimeErrorOptions options{scene.dt, 0.005};
  said.end = work.end_step(&options);
  said.energy = work.finish();
  work.download(said.state, StateParts::kAll);
  return said;
}

void expect_stage(const StageSaid& card, const StageSaid& host) {
  for (size_t k = 0; k < host.starts.size(); ++k) {
    EXPECT_LT(relative_difference(card.starts[k], host.starts[k]), 1e-11) << "start " << k;
  }
  for (size_t k = 0; k < host.phi.size(); ++k)
    EXPECT_NEAR(card.phi[k], host.phi[k], 1e-3 * std::abs(host.phi[k])) << "start " << k;
  EXPECT_NEAR(card.farthest, host.farthest, 1e-11 * host.farthest);
  EXPECT_EQ(card.rubs, host.rubs);
  EXPECT_LT(relative_difference(card.gradient, host.gradient), 1e-9);
  const PotentialValue &a = card.certificate.value, &b = host.certificate.value;
  EXPECT_NEAR(card.certificate.size, host.certificate.size, 1e-9 * host.certificate.size);
  EXPECT_NEAR(a.contact, b.contact, 1e-9 * b.contact);
  EXPECT_NEAR(a.inertia, b.inertia, 1e-9 * b.inertia);
  EXPECT_NEAR(a.total(), b.total(), 1e-9 * b.total());
  EXPECT_TRUE(card.certificate.finite);
}

/// The ledgers of a step; positions of the stages are the same, so impulses and works are.
void expect_ledger(const StepLedger& card, const StepLedger& host) {
  ASSERT_TRUE(card.known && host.known);
  const auto expect_momenta = [](const TwoMomenta& a, const TwoMomenta& b, double size) {
    EXPECT_LT(safe_norm(minus(a.linear, b.linear)), 1e-8 * size);
    EXPECT_LT(safe_norm(minus(a.angular, b.angular)), 1e-8 * size);
  };
  const double size = safe_norm(host.end.momentum.linear) + safe_norm(host.done.gravity.linear) +
                      safe_norm(host.done.contact.linear) + safe_norm(host.done.pins.linear);
  expect_momenta(card.end.momentum, host.end.momentum, size);
  expect_momenta(card.done.gravity, host.done.gravity, size);
  expect_momenta(card.done.contact, host.done.contact, size);
  expect_momenta(card.done.pins, host.done.pins, size);
  const double energy = host.end.energy.kinetic + host.end.energy.elastic +
                        std::abs(host.done.residual) + std::abs(host.done.rubbed);
  EXPECT_NEAR(card.end.energy.total(), host.end.energy.total(), 1e-8 * energy);
  EXPECT_NEAR(card.end.energy.bonds, host.end.energy.bonds, 1e-8 * energy);
  EXPECT_NEAR(card.done.residual, host.done.residual, 1e-8 * energy);
  EXPECT_NEAR(card.done.rubbed, host.done.rubbed, 1e-8 * energy);
  EXPECT_NEAR(card.done.colliders, host.done.colliders, 1e-8 * energy);
  EXPECT_NEAR(card.correction, host.correction, 1e-8 * energy);
}

void expect_step(const StepSaid& card, const StepSaid& host) {
  expect_ledger(card.end.ledger, host.end.ledger);
  EXPECT_NEAR(card.least, host.least, 1e-11 * host.least);
  for (size_t s = 0; s < host.stages.size(); ++s) {
    SCOPED_TRACE(concat("stage ", s));
    expect_stage(card.stages[s], host.stages[s]);
  }
  EXPECT_EQ(card.end.keeps_energy, host.end.keeps_energy);
  // S y is known to a twentieth
  EXPECT_NEAR(card.end.error.estimate, host.end.error.estimate, 0.1 * host.end.error.estimate);
  EXPECT_NEAR(card.end.error.ratio, host.end.error.ratio, 0.1 * host.end.error.ratio);
  EXPECT_NEAR(card.energy.kinetic, host.energy.kinetic, 1e-9 * host.energy.kinetic);
  EXPECT_NEAR(card.energy.gravity, host.energy.gravity, 1e-9 * std::abs(host.energy.gravity));
  EXPECT_LT(relative_difference(card.state.x, host.state.x), 1e-13);
  EXPECT_LT(relative_difference(card.state.v, host.state.v), 1e-9);
  EXPECT_EQ(card.state.h_before, host.state.h_before);
  EXPECT_LT(relative_difference(card.state.v_before, host.state.v_before), 1e-9);
}

/// Steps of all kinds, one after the other, so that what is kept from step to step counts as well.
/// @return how many stages felt friction.
int expect_steps(const Scene& scene, const State& from) {
  const StepScheme of_run(scene.scheme, scene.dt, 2.25);
  const PotentialTerms terms(scene, {}, of_run);
  const EncoderChoice encoder;
  const auto card = cuda::make_device_step(terms, &encoder, {});
  const auto host = make_host_step(PotentialTerms(scene, {}, of_run), &encoder, {}, true);
  card->upload(from);
  host->upload(from);
  double time = from.time, h_before = 0;
  int step = 0, rubbing = 0;
  for (const TimeScheme kind : {TimeScheme::kEuler, TimeScheme::kBdf2, TimeScheme::kSdirk2,
                                TimeScheme::kBdf2, TimeScheme::kEuler}) {
    SCOPED_TRACE(concat("step ", step, ", scheme ", scheme_name(kind)));
    const double h = scene.dt * (step % 2 == 0 ? 0.5 : 0.7);
    const StepSaid b = make_step(*host, scene, kind, h, h_before, time);
    const StepSaid a = make_step(*card, scene, kind, h, h_before, time);
    expect_step(a, b);
    for (const StageSaid& stage : b.stages) rubbing += stage.rubs;
    time += h, h_before = h, ++step;
  }
  return rubbing;
}

Scene in_stages(Scene scene, double dt) {
  scene.scheme = TimeScheme::kAuto;
  scene.dt = dt;
  finish_scene(scene);
  return scene;
}

TEST_F(OnCard, StagesOfPiecesWithAndWithoutPinsAreTheHosts) {
  const Scene scene = in_stages(three_blocks(TimeScheme::kEuler), 1.0 / 60);
  EXPECT_EQ(expect_steps(scene, in_motion(scene)), 0);
}

TEST_F(OnCard, StagesOfNodesThatFollowOthersAreTheHosts) {
  const Scene scene = in_stages(swinging_bar(TimeScheme::kEuler), 1.0 / 60);
  EXPECT_EQ(expect_steps(scene, bar_in_motion(scene)), 0);
}

TEST_F(OnCard, StagesOfBodiesThatTurnThoughTheyAreHeldAreTheHosts) {
  // on a corner that voxels are cut for, and along an axis
  const MovingScene hung = block_on_a_corner(1), thrown = thrown_box(true);
  for (const MovingScene& m : {hung, thrown}) {
    const Scene scene = in_stages(m.scene, kFrame);
    EXPECT_EQ(expect_steps(scene, m.start), 0);
  }
}

TEST_F(OnCard, StagesOfABlockThatRubsAreTheHosts) {
  const MovingScene m = block_on_slope(1e6, 0.5, 0.4);
  const Scene scene = in_stages(m.scene, kFrame / 4);
  State state = m.start;
  for (int64_t n = 0; n < state.v.rows(); ++n) state.v(n, 0) = 0.3;
  EXPECT_GE(expect_steps(scene, state), 5);
}

TEST_F(OnCard, StagesBesideAColliderThatMovesAreTheHosts) {
  MovingScene m = block_on_floor(1e6, 0);
  m.scene.colliders[0].path = {{0, {}}, {1, {0.2, 0.1, 0}}};
  State state = m.start;
  for (int64_t n = 0; n < state.v.rows(); ++n) state.v(n, 2) = 0.2;
  EXPECT_GE(expect_steps(in_stages(m.scene, kFrame / 4), state), 5);
}

/// Iterations on B r = A^-1 r count on B for steps of any length.
TEST_F(OnCard, TheFirstMatrixFollowsTheLengthOfSteps) {
  for (const Scene& base : {three_blocks(TimeScheme::kEuler), block_on_floor(1e5, 0.1).scene}) {
    const Scene scene = in_stages(base, 1.0 / 60);
    const StepScheme of_run(scene.scheme, scene.dt, 2.25);
    const PotentialTerms terms(scene, {}, of_run);
    const EncoderChoice encoder;
    const auto card = cuda::make_device_step(terms, &encoder, {});
    const auto host = make_host_step(PotentialTerms(scene, {}, of_run), &encoder, {}, true);
    State state = initial_state(scene, {.velocity = {0.5, 1, 0}, .spin = {2, 3, -1}});
    for (const double h : {scene.dt, scene.dt / 16, 4 * scene.dt}) {
      SCOPED_TRACE(concat("step of ", h, " s of a scene of ", scene.grid.voxel_count(), " voxels"));
      // the same Newton steps on both machines
      int inner[2] = {};
      for (StepWork* work : {host.get(), card.get()}) {
        work->upload(state);
        work->begin_step(StepScheme(TimeScheme::kEuler, euler_stage(h)), 0);
        work->clear_start();
        work->set_nodal_rotations();
        const double target = 1e-6 * reference_force(scene);
        const IterationResult found = work->newton(target, 30, 400, [] { return false; });
        EXPECT_TRUE(found.converged);
        inner[work == card.get()] = found.inner;
      }
      EXPECT_LE(inner[1], 1.3 * inner[0] + 4);
    }
  }
}

}  // namespace
}  // namespace elastogen::test

#endif
