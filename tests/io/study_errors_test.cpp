// SPDX-License-Identifier: Apache-2.0
#include "io/study_errors.hpp"

#include "tests/io/study_example.hpp"
#include "tests/io/test_files.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace elastogen {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A run with one largest error of a step against a reference.
StudyRun run_with(const std::string& name, const std::string& solver, double ms, double error,
                  const std::string& reference = "reference") {
  StudyRun run;
  run.name = name;
  run.solver = solver;
  run.step_ms.median = ms;
  run.solver_error = StudyErrors{reference, {{}, error}, {{}, kInfinity}, 1, 0};
  return run;
}

/// The runs that reached 1e-1 ... 1e-4, of the entry of a solver, reference and measure.
std::vector<std::string> reached(const std::vector<StudyRun>& runs, const std::string& solver,
                                 const std::string& reference = "reference",
                                 ErrorMeasure measure = ErrorMeasure::kStep,
                                 ErrorFamily family = ErrorFamily::kSolver) {
  std::vector<std::string> names;
  for (const TimeToError& entry : times_to_error(runs))
    if (entry.solver == solver && entry.reference == reference && entry.measure == measure &&
        entry.family == family)
      for (const ReachedError& level : entry.levels) {
        EXPECT_EQ(level.run.empty(), !level.ms.has_value());
        names.push_back(level.run);
      }
  return names;
}

using Names = std::vector<std::string>;

TEST(TimesToError, TakeTheCheapestRunThatReachesEachError) {
  const std::vector<StudyRun> runs = {
      run_with("slow", "quasi", 30, 5e-4), run_with("loose", "quasi", 5, 5e-2),
      run_with("tight", "quasi", 20, 2e-4), run_with("other", "newton", 1, 1e-9)};
  EXPECT_EQ(reached(runs, "quasi"), (Names{"loose", "tight", "tight", ""}));
  EXPECT_EQ(reached(runs, "newton"), Names(4, "other"));
  EXPECT_EQ(times_to_error(runs)[0].levels[1].ms, 20);
}

TEST(TimesToError, CountAnErrorOfExactlyTheLevelAndTheFirstOfEqualTimes) {
  EXPECT_EQ(reached({run_with("a", "quasi", 5, 1e-3), run_with("b", "quasi", 5, 1e-3)}, "quasi"),
            (Names{"a", "a", "a", ""}));
}

TEST(TimesToError, DoNotCountWhatIsNoNumber) {
  EXPECT_EQ(reached({run_with("a", "quasi", 1, kNan), run_with("b", "quasi", kNan, 1e-5),
                     run_with("c", "quasi", kInfinity, 1e-5), run_with("d", "quasi", 9, kInfinity)},
                    "quasi"),
            Names(4, ""));
}

TEST(TimesToError, KeepReferencesMeasuresAndFamiliesApart) {
  std::vector<StudyRun> runs = {run_with("coarse", "quasi", 1, 1e-5, "coarse newton"),
                                run_with("fine", "quasi", 100, 1e-5, "fine newton")};
  EXPECT_EQ(reached(runs, "quasi", "fine newton"), Names(4, "fine"));
  EXPECT_EQ(reached(runs, "quasi", "coarse newton"), Names(4, "coarse"));
  EXPECT_EQ(reached(runs, "quasi", "fine newton", ErrorMeasure::kFreeRun), Names(4, ""));
  const auto discretisation = [&] {
    return reached(runs, "quasi", "fine newton", ErrorMeasure::kStep, ErrorFamily::kDiscretisation);
  };
  EXPECT_EQ(discretisation(), Names());
  runs[0].discretisation_error = StudyErrors{"fine newton", {{}, 0.05}, {{}, 1}, 1, 0};
  EXPECT_EQ(discretisation(), (Names{"coarse", "", "", ""}));
  EXPECT_TRUE(times_to_error({}).empty());
}

TEST(ObservedOrder, IsTheExponentOfAPower) {
  EXPECT_NEAR(observed_order({0.1, 0.2, 0.4, 0.8}, {0.03, 0.12, 0.48, 1.92}), 2, 1e-14);
  EXPECT_NEAR(observed_order({1e-3, 1e-2}, {5e-2, 5e-2}), 0, 1e-15);
  // slope of least squares through (0,0), (1,1), (2,1) in decades: 1/2
  EXPECT_NEAR(observed_order({1, 10, 100}, {1, 10, 10}), 0.5, 1e-14);
}

TEST(ObservedOrder, LeavesOutWhatHasNoLogarithm) {
  EXPECT_NEAR(observed_order({1, 0, 2, -1, 4, kNan}, {1, 9, 2, 9, 4, 9}), 1, 1e-14);
  EXPECT_NEAR(observed_order({1, 3, 2}, {1, 0, 8}), 3, 1e-14);
  EXPECT_TRUE(std::isnan(observed_order({}, {})));
  EXPECT_TRUE(std::isnan(observed_order({2}, {3})));
  EXPECT_TRUE(std::isnan(observed_order({2, 2}, {3, 4})));
  test::error_of([] { observed_order({1, 2}, {1}); }, ErrorKind::kUsage);
}

TEST(Contradiction, IsNamed) {
  StudyResult study = test::example_study();
  EXPECT_EQ(contradiction_in(study), "");
  study.runs[1].name = study.runs[0].name;
  test::expect_says(contradiction_in(study), "two runs have the name 'quasi 1e-2'");

  study = test::example_study();
  study.runs[2].energy.contact.pop_back();
  test::expect_says(contradiction_in(study), "energies of run 'newton 1e-3'");

  study = test::example_study();
  study.sweeps[0].x.pop_back();
  test::expect_says(contradiction_in(study), "sweep 'quasi, voxel' has 2 x and 3 errors");
}

}  // namespace
}  // namespace elastogen
