// SPDX-License-Identifier: Apache-2.0
// Reactions of finite elements: against the network's, and the balance of what is free.
#include "core/vec3.hpp"
#include "scene/stepper.hpp"
#include "tests/scene/long_bar.hpp"

#include <gtest/gtest.h>

namespace elastogen {
namespace {

/// A soft bar, held at both ends on a grid that fits the left one only.
RunDescription bar_run(TimeScheme scheme, std::vector<std::string> moves = {}) {
  RunDescription run;
  run.h = 0.0531;
  run.material.law = Law::kNeoHookean;
  run.material.young = 2e5;
  run.material.poisson = 0.3;
  run.energy = EnergySource::kAnalytic;
  run.scheme = scheme;
  run.solver.mode = SolverMode::kNewton;
  run.solver.device = Device::kCpu;
  run.solver.tolerance = 1e-9;
  run.solver.follows_time_error = false;
  run.pins.push_back(parse_pin("x<1%"));
  if (moves.empty()) run.pins.push_back(parse_pin("x>99%"));
  for (const std::string& move : moves) run.moves.push_back(parse_move(move));
  return run;
}

RunDescription elements(RunDescription run, fem::Element element,
                        fem::Mass mass = fem::Mass::kLumped) {
  run.fem = FemOptions{.element = element, .named = true, .mass = mass};
  return run;
}

/// Reports and velocities after some steps, each of which must converge.
struct Played {
  std::vector<StepReport> reports;
  std::vector<Array<double>> velocities;
};

Played play(const Setup& setup, const RunDescription& run, int steps) {
  std::vector<std::string> notes;
  const std::unique_ptr<Stepper> stepper = make_stepper(setup, run, {}, notes);
  stepper->begin({});
  Played played;
  for (int k = 0; k < steps; ++k) {
    played.reports.push_back(stepper->advance());
    EXPECT_TRUE(played.reports.back().converged) << played.reports.back().residual;
    played.velocities.push_back(stepper->state().v);
  }
  return played;
}

Vec3 momentum(const Setup& setup, const Array<double>& v) {
  Vec3 sum = {};
  for (int64_t n = 0; n < setup.scene.mass.rows(); ++n)
    for (int d = 0; d < 3; ++d) sum[size_t(d)] += setup.scene.mass(n) * v(n, d);
  return sum;
}

/// Weight of what pins leave of the bar [N].
double free_weight(const RunDescription& run) {
  return 0.98 * 0.2 * 0.2 * run.material.density * 9.81;
}

Vec3 sum_of(const std::vector<Reaction>& reactions) {
  Vec3 sum = {};
  for (const Reaction& one : reactions) sum = plus(sum, one.force);
  return sum;
}

constexpr const char* kTurnedEnd = "x>99%: turn(50%,50%,50%,1,0,0) ease 0:0; 0.2:60deg";
constexpr const char* kShiftedEnd = "x>99%: shift ease 0:0,0,0; 0.2:3cm,-2cm,1cm";

TEST(FemReactions, AreThoseOfTheNetworkInAllSchemes) {
  for (const TimeScheme scheme :
       {TimeScheme::kEuler, TimeScheme::kBdf2, TimeScheme::kSdirk2, TimeScheme::kAuto})
    for (const std::vector<std::string>& moves :
         {std::vector<std::string>{}, {kTurnedEnd}, {kShiftedEnd}}) {
      const RunDescription run = bar_run(scheme, moves);
      const auto setup = set_up(long_bar(), run);
      ASSERT_FALSE(setup.scene.dependent.empty());
      const Played network = play(setup, run, 5),
                   own = play(setup, elements(run, fem::Element::kVoxel), 5);
      for (size_t k = 0; k < 5; ++k) {
        ASSERT_EQ(own.reports[k].reactions.size(), 2u);
        for (size_t h = 0; h < 2; ++h) {
          const Reaction &a = network.reports[k].reactions[h], &b = own.reports[k].reactions[h];
          EXPECT_LT(norm(minus(a.force, b.force)), 1e-6 * norm(a.force)) << int(scheme) << ' ' << k;
          EXPECT_LT(norm(minus(a.moment, b.moment)), 1e-6 * norm(a.moment)) << int(scheme);
          EXPECT_LT(norm(minus(a.about, b.about)), 1e-8);
        }
      }
    }
}

TEST(FemReactions, AreTheWeightAndTheRateOfMomentumOfWhatIsFree) {
  for (const fem::Element element :
       {fem::Element::kVoxel, fem::Element::kHex, fem::Element::kHexBbar}) {
    const RunDescription run = elements(bar_run(TimeScheme::kEuler), element);
    const auto setup = set_up(long_bar(), run);
    const Played played = play(setup, run, 4);
    const double weight = free_weight(run);
    for (size_t k = 1; k < 4; ++k) {
      const Vec3 rate = scaled(
          minus(momentum(setup, played.velocities[k]), momentum(setup, played.velocities[k - 1])),
          1 / setup.scene.dt);
      const Vec3 expected = plus(rate, {0, weight, 0});
      EXPECT_GT(norm(rate), 0.02 * weight);
      EXPECT_LT(norm(minus(sum_of(played.reports[k].reactions), expected)), 1e-6 * weight)
          << element_name(element) << ' ' << k;
    }
  }
}

TEST(FemReactions, CarryTheWeightOfABodyAtRest) {
  // one long step: inertia is 1e-9 of the weight
  for (const fem::Mass mass : {fem::Mass::kLumped, fem::Mass::kConsistent})
    for (const bool newmark : {false, true})
      for (const TimeScheme scheme : {TimeScheme::kEuler, TimeScheme::kSdirk2}) {
        if (newmark && scheme != TimeScheme::kEuler) continue;
        RunDescription run = elements(bar_run(scheme), fem::Element::kHex, mass);
        run.fem->newmark = newmark;
        run.material.young = 1e7;
        run.fps = newmark ? 30 : 1e-4;
        run.substeps = 1;
        const auto setup = set_up(long_bar(), run);
        const StepReport report = play(setup, run, 1).reports.back();
        const double weight = free_weight(run);
        if (!newmark) {
          EXPECT_NEAR(sum_of(report.reactions)[1], weight, 1e-6 * weight);
        }
        // by symmetry of the bar both ends carry half, but for what the grid cuts
        EXPECT_NEAR(report.reactions[0].force[1] / report.reactions[1].force[1], 1, 0.02);
        EXPECT_NEAR(report.reactions[0].moment[2] / report.reactions[1].moment[2], -1, 0.05);
      }
}

TEST(FemReactions, OfTetrahedraCarryTheWeightOfWhatIsFree) {
  for (const fem::Element element : {fem::Element::kTet4, fem::Element::kTet10})
    for (const bool statics : {true, false}) {
      RunDescription run = elements(bar_run(TimeScheme::kEuler), element);
      run.material.young = 1e7;
      run.fem->statics = statics;
      run.fps = statics ? 30 : 1e-4;
      run.substeps = 1;
      const auto setup = set_up(long_bar(), run);
      ASSERT_TRUE(setup.cut_mesh.has_value());
      const StepReport report = play(setup, run, 1).reports.back();
      ASSERT_EQ(report.reactions.size(), 2u);
      const double weight = free_weight(run);
      EXPECT_NEAR(sum_of(report.reactions)[1], weight, 1e-6 * weight) << element_name(element);
      EXPECT_NEAR(report.reactions[0].force[1], report.reactions[1].force[1], 0.02 * weight);
      EXPECT_NEAR(report.reactions[0].force[0], -report.reactions[1].force[0], 1e-6 * weight);
    }
}

TEST(FemReactions, OfAPinThatHoldsNothingAre0) {
  RunDescription run = elements(bar_run(TimeScheme::kEuler), fem::Element::kVoxel);
  run.pins.push_back(parse_pin("x<-5%"));
  const auto setup = set_up(long_bar(), run);
  const StepReport report = play(setup, run, 1).reports.back();
  ASSERT_EQ(report.reactions.size(), 3u);
  EXPECT_EQ(report.reactions[2].force, Vec3{});
  EXPECT_GT(report.reactions[0].force[1], 0);
}

}  // namespace
}  // namespace elastogen
