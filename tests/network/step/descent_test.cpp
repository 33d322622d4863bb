// SPDX-License-Identifier: Apache-2.0
// Within a step: the incremental potential falls with every outer iteration, and the residual is
// that of the true stress whenever the iteration is cut.
#include "core/time_scheme.hpp"
#include "network/solver.hpp"
#include "tests/network/scenes.hpp"

#include <gtest/gtest.h>

namespace elastogen::test {
namespace {

struct Cut {
  double potential = 0, residual = 0, reported = 0;
};

/// The state after so many outer iterations of one step from `start`.
Cut cut_after(const Scene& scene, const State& start, SolverMode mode, int outer) {
  Solver solver(scene, {.mode = mode, .tolerance = 1e-9, .max_outer = outer, .skip = false});
  State state = start;
  const StepReport report = solver.step(state);
  EXPECT_EQ(report.outer, outer);
  IncrementalPotential potential(scene);
  potential.begin_step(start, step_scheme(scene, start));
  const std::vector<double> u = displacement(scene, state);
  std::vector<double> g(u.size());
  const double value = potential.evaluate<double>(u.data(), g.data()).total();
  return {value, norm(g) / reference_force(scene), report.residual};
}

TEST(Descent, ThePotentialFallsWithEveryOuterIteration) {
  for (const Law law : {Law::kNeoHookean, Law::kStvk, Law::kFixedCorotated})
    for (const TimeScheme scheme : {TimeScheme::kEuler, TimeScheme::kBdf2})
      for (const SolverMode mode : {SolverMode::kQuasi, SolverMode::kNewton}) {
        Scene scene = clamped_beam(12, 3, 3, 0.05, solid(2e5, 0.4, law));
        scene.scheme = scheme;
        finish_scene(scene);
        State state = initial_state(scene);
        Solver solver(scene, {.mode = mode});
        for (int k = 0; k < 4; ++k) ASSERT_TRUE(solver.step(state).converged);
        double before = 1e300;
        for (int outer = 1; outer <= (mode == SolverMode::kNewton ? 3 : 12); ++outer) {
          const Cut cut = cut_after(scene, state, mode, outer);
          EXPECT_LT(cut.potential, before) << law_name(law) << ' ' << solver_name(mode) << outer;
          EXPECT_NEAR(cut.residual / cut.reported, 1, 1e-9);
          before = cut.potential;
        }
      }
}

}  // namespace
}  // namespace elastogen::test
