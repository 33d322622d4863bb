// SPDX-License-Identifier: Apache-2.0
// Steps with a net in the place of a law. The net whose weights are 0 is the Hencky law, so a beam
// of another law that carries it must move as a beam of Hencky's does.

#include "core/error.hpp"
#include "network/solver.hpp"
#include "tests/network/scenes.hpp"

#include <gtest/gtest.h>

namespace elastogen::test {
namespace {

Scene held_beam(Law law) {
  return clamped_beam(12, 3, 3, 0.05, solid(2e5, 0.4, law));
}

LearnedLaws hencky_net(Law law, Evaluation evaluation) {
  const std::vector<float> zero(size_t(NeuralMtl::kParameters), 0.0f);
  return {std::make_shared<LearnedLaw>(zero, law, 0.4, "none", evaluation)};
}

struct Motion {
  State state;
  int outer = 0;
  int64_t outside = 0;
  bool converged = true;
};

Motion run(const Scene& scene, const SolverOptions& options, int steps) {
  Motion result{.state = initial_state(scene)};
  Solver solver(scene, options);
  for (int k = 0; k < steps; ++k) {
    const StepReport report = solver.step(result.state);
    result.outer += report.outer;
    result.outside += report.outside_fit;
    result.converged &= report.converged;
  }
  return result;
}

/// Largest difference of positions over the largest displacement.
double difference(const Scene& scene, const State& a, const State& b) {
  double most = 0, moved = 0;
  for (int64_t k = 0; k < a.x.size(); ++k) {
    most = std::max(most, std::abs(a.x.data()[k] - b.x.data()[k]));
    moved = std::max(moved, std::abs(b.x.data()[k] - scene.grid.rest.data()[k]));
  }
  return most / moved;
}

TEST(LearnedScene, MovesAsTheLawThatItsNetIs) {
  const Scene exact = held_beam(Law::kHencky), carrier = held_beam(Law::kNeoHookean);
  for (const SolverMode mode : {SolverMode::kQuasi, SolverMode::kNewton}) {
    SolverOptions options{.mode = mode, .tolerance = 1e-6};
    const Motion reference = run(exact, options, 8);
    options.learned = hencky_net(Law::kNeoHookean, Evaluation::kNet);
    const Motion by_net = run(carrier, options, 8);
    options.learned = hencky_net(Law::kNeoHookean, Evaluation::kTable);
    const Motion by_table = run(carrier, options, 8);
    EXPECT_TRUE(reference.converged && by_net.converged && by_table.converged);
    EXPECT_LT(difference(exact, by_net.state, reference.state), 1e-6) << solver_name(mode);
    EXPECT_LT(difference(exact, by_table.state, reference.state), 2e-4) << solver_name(mode);
    EXPECT_NEAR(by_net.outer, reference.outer, 0.05 * reference.outer + 1);
    EXPECT_NEAR(by_table.outer, reference.outer, 0.1 * reference.outer + 1);
    EXPECT_EQ(by_net.outside, 0);
    // and not as the law that it stands on
    options.learned = {};
    EXPECT_GT(difference(exact, run(carrier, options, 8).state, reference.state), 2e-3);
  }
}

TEST(LearnedScene, PaperModeFitsItsStretchesToTheEnergyOfTheNet) {
  Scene exact = held_beam(Law::kHencky), carrier = held_beam(Law::kNeoHookean);
  for (Scene* scene : {&exact, &carrier}) {
    scene->hourglass = Hourglass::kVariance;
    finish_scene(*scene);
  }
  SolverOptions options{.mode = SolverMode::kPaper};
  const Motion reference = run(exact, options, 4);
  options.learned = hencky_net(Law::kNeoHookean, Evaluation::kNet);
  EXPECT_LT(difference(exact, run(carrier, options, 4).state, reference.state), 1e-10);
}

TEST(LearnedScene, CountsTheVoxelsThatLeaveTheBox) {
  const Scene scene = held_beam(Law::kNeoHookean);
  SolverOptions options{.tolerance = 1e-3};
  options.learned = hencky_net(Law::kNeoHookean, Evaluation::kTable);
  IncrementalPotential potential(scene, options.learned);
  State state = initial_state(scene);
  potential.begin_step(state, {TimeScheme::kEuler, scene.dt, 1});
  std::vector<double> u(size_t(state.x.size())), g(u.size());
  for (int64_t n = 0; n < state.x.rows(); ++n) u[size_t(3 * n)] = 1.7 * scene.grid.rest(n, 0);
  EXPECT_EQ(potential.evaluate<double>(u.data(), g.data()).outside, scene.grid.voxel_count());
  for (double& value : u) value /= 2;  // stretch 1.85: ln 1.85 is in the box
  EXPECT_EQ(potential.evaluate<double>(u.data(), g.data()).outside, 0);
}

TEST(LearnedScene, RefusesANetOfAnotherMaterial) {
  const Scene scene = held_beam(Law::kNeoHookean);
  SolverOptions options;
  options.learned = hencky_net(Law::kStvk, Evaluation::kNet);
  EXPECT_THROW(Solver(scene, options), Error);
}

}  // namespace
}  // namespace elastogen::test
