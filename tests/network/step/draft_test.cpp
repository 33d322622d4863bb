// SPDX-License-Identifier: Apache-2.0
// Steps that could not be solved say why, with the numbers of what is written.
#include "network/step/draft.hpp"

#include "core/time_scheme.hpp"
#include "network/solver.hpp"
#include "tests/network/scenes.hpp"

#include <gtest/gtest.h>

#include <iomanip>
#include <sstream>

namespace elastogen::test {
namespace {

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(Draft, NamesTheLargestForceItsPlaceAndTheLoad) {
  Scene scene = clamped_beam(4, 1, 1, 0.5, solid(2000, 0.3));
  scene.place = {10, 0, 0};
  // a force of 25 N of a free node, and a larger one of a pinned node, which its holder bears
  Array<double> gradient(scene.grid.node_count(), 3);
  for (int64_t n = 0; n < scene.grid.node_count(); ++n) {
    if (scene.pinned(n) == kPinnedNode) gradient(n, 0) = 1000;
    if (scene.grid.rest(n, 0) == 1.5 && scene.grid.rest(n, 1) == 0.5 && scene.grid.rest(n, 2) == 0)
      gradient(n, 0) = -15, gradient(n, 1) = 20;
  }
  StepReport step;
  step.step = 7, step.residual = 0.25, step.tolerance = 1e-3, step.outer = 3, step.inner = 40;
  step.min_j = -0.5;
  const std::string text = why_draft(scene, step, gradient);
  EXPECT_TRUE(
      has(text, "step 7 is not solved: residual 0.25 (0.001 allowed) after 3 outer and 40 inner"))
      << text;
  EXPECT_TRUE(has(text, "25 N or 0.05 E h^2, is at (11.5, 0.5, 0) m")) << text;  // E h^2 = 500 N
  EXPECT_TRUE(has(text, "the smallest det F is -0.5")) << text;
  EXPECT_TRUE(has(text, "about 9.8e+02 % under its own weight")) << text;  // 1000 g 2 / 2000
}

TEST(Draft, StepsThatConvergeHaveNoneAndOthersTellTheirResidual) {
  for (const TimeScheme kind : {TimeScheme::kEuler, TimeScheme::kAuto}) {
    for (const int most : {1, 100}) {
      Scene scene = clamped_beam(8, 2, 2, 0.1, solid(1e4, 0.3));
      scene.scheme = kind;
      Solver solver(scene, {.mode = SolverMode::kQuasi,
                            .tolerance = 1e-5,
                            .follows_time_error = false,
                            .max_outer = most});
      State state = initial_state(scene);
      const StepReport report = solver.step(state);
      ASSERT_TRUE(report.finite);
      EXPECT_EQ(report.converged, report.refusal.empty()) << report.refusal;
      if (kind == TimeScheme::kAuto) continue;  // it may take steps that are short enough
      EXPECT_EQ(report.converged, most == 100);
      if (report.converged) continue;
      // the force that it names is the largest of the residual
      double largest = 0;
      const Span<const double> r = solver.residual();
      for (int64_t n = 0; n < r.rows; ++n)
        if (scene.pinned(n) == kFreeNode)
          largest = std::max(largest, safe_norm({r(n, 0), r(n, 1), r(n, 2)}));
      std::ostringstream force;
      force << std::setprecision(3) << largest << " N";
      EXPECT_TRUE(has(report.refusal, force.str())) << report.refusal;
    }
  }
}

}  // namespace
}  // namespace elastogen::test
