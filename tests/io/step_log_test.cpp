// SPDX-License-Identifier: Apache-2.0
#include "io/step_log.hpp"

#include "core/error.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <limits>

namespace elastogen {
namespace {

using Json = nlohmann::json;

StepReport example() {
  StepReport report;
  report.step = 7;
  report.time = 0.25;
  report.scheme = TimeScheme::kBdf2;
  report.converged = true;
  report.residual = 3.5e-4;
  report.outer = 12;
  report.inner = 14;
  report.float64 = true;
  report.min_j = 0.875;
  report.min_corner_j = 0.5;
  report.outside_fit = 9;
  report.energy = {1, 2, 3, 4, 5};
  report.active_share = 0.75;
  report.deepest_overlap = 0.0625;
  report.ms = 41.5;
  return report;
}

TEST(StepLog, LineHasEveryFieldOfTheDocumentation) {
  const Json expected = Json::parse(R"({"frame": 3, "step": 7, "time": 0.25, "converged": true,
      "residual": 3.5e-4, "outer": 12, "inner": 14, "scheme": "bdf2", "float64": true,
      "finite": true, "min_j": 0.875, "min_corner_j": 0.5, "outside_fit": 9,
      "energies": {"kinetic": 1, "elastic": 2, "hourglass": 3, "gravity": 4, "contact": 5},
      "active_share": 0.75, "deepest_overlap": 0.0625, "ms": 41.5})");
  EXPECT_EQ(Json::parse(step_log_line(3, example())), expected);
}

TEST(StepLog, WritesNullForWhatIsNotFinite) {
  StepReport report = example();
  report.residual = std::numeric_limits<double>::quiet_NaN();
  report.min_j = -std::numeric_limits<double>::infinity();
  const Json line = Json::parse(step_log_line(1, report));
  EXPECT_TRUE(line["residual"].is_null());
  EXPECT_TRUE(line["min_j"].is_null());
}

TEST(StepLog, HasALineAStepThatCanBeReadAtOnce) {
  const std::string path =
      std::filesystem::temp_directory_path() / ("elastogen_log_" + std::to_string(getpid()));
  StepLog log(path);
  for (int step = 1; step <= 3; ++step) {
    StepReport report = example();
    report.step = step;
    log.write(step, report);
    std::ifstream file(path);
    std::string line;
    int lines = 0;
    while (std::getline(file, line)) EXPECT_EQ(Json::parse(line)["step"], ++lines);
    EXPECT_EQ(lines, step);
  }
  std::filesystem::remove(path);
}

TEST(StepLog, RejectsAMissingFolderAndAFullDisk) {
  const auto kind_of = [](const auto& action) {
    try {
      action();
    } catch (const Error& error) {
      return error.kind();
    }
    return ErrorKind::kUsage;
  };
  EXPECT_EQ(kind_of([] { StepLog("/nonexistent/log.json"); }), ErrorKind::kResources);
  EXPECT_EQ(kind_of([] { StepLog("/dev/full").write(1, example()); }), ErrorKind::kResources);
}

}  // namespace
}  // namespace elastogen
