// SPDX-License-Identifier: Apache-2.0
#include "io/report_file.hpp"

#include "core/error.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>

namespace elastogen {
namespace {

using Json = nlohmann::json;

std::string scratch() {
  return std::filesystem::temp_directory_path() / ("elastogen_report_" + std::to_string(getpid()));
}

Json written(const RunReport& report) {
  write_report(scratch(), report);
  std::ifstream file(scratch());
  const Json json = Json::parse(file);
  std::filesystem::remove(scratch());
  return json;
}

TEST(ReportFile, HasEveryFieldOfTheDocumentation) {
  // a report, then the JSON that it gives
  RunReport report;
  report.asset = {"cat.obj",
                  "obj",
                  100,
                  196,
                  true,
                  {0.5, {true, "no unit"}, ""},
                  {{2, -1}, {false, "asked for"}},
                  {{"zero-area", 2, "2 triangles dropped"}}};
  report.voxels = 10;
  report.nodes = 30;
  report.h = 0.125;
  report.materials = {{"foam", Law::kHencky, 2e4, 0.25, 30}, {"band", Law::gent(8), 1, 0, 1}};
  report.materials[0].loss_factor = 0.2;
  report.materials[1].loss_frequency = 5;
  report.nets = {"0123abcd", ""};
  report.steps = 4;
  report.frames = 2;
  report.converged_share = 0.75, report.solved_share = 1;
  report.worst_residual = 2e-3;
  report.min_j = 0.5;
  report.damped = 3.5;
  report.time_error = 1e-3;
  report.largest_time_error = 2e-4, report.frames_over = 1;
  report.mesh_error = {
      .frames = 6, .untrusted = 1, .rms = 1e-3, .largest = 4e-3, .largest_motion = 0.2};
  report.loosest_tolerance = 0.1;
  report.solves = 9;
  report.rejected_steps = 1;
  report.outside_fit = 12;
  report.long_steps = {3, 7};
  report.stage_seconds = {1, 2, 3, 4, 5};
  report.step_ms = {1, 2, 3, 4, 5};
  report.peak_memory_bytes = 123456789012;
  report.notes = {"band is taken by its law"};
  report.warnings = {"nothing moved"};
  report.command = "elastogen animate cat.obj";
  report.commit = "abc123";
  const Json expected = Json::parse(R"({"asset": {"path": "cat.obj", "format": "obj",
      "vertices": 100, "faces": 196, "closed": true,
      "size": {"longest_edge": 0.5, "guessed": true, "reason": "no unit"},
      "up": {"axis": "-z", "guessed": false, "reason": "asked for"}, "findings": [
        {"what": "zero-area", "severity": "note", "count": 2, "text": "2 triangles dropped"}]},
      "voxels": 10, "nodes": 30, "h": 0.125, "materials": [{"name": "foam", "law": "hencky",
        "young": 2e4, "poisson": 0.25, "density": 30.0, "loss_factor": 0.2,
        "loss_frequency": 10.0, "net": "0123abcd"},
        {"name": "band", "law": "gent=8", "young": 1.0, "poisson": 0.0, "density": 1.0, "loss_factor": 0.0,
        "loss_frequency": 5.0}], "device": "cpu",
      "steps": 4, "frames": 2,
      "converged_share": 0.75, "solved_share": 1.0, "worst_residual": 2e-3, "min_j": 0.5,
      "time_error": {"sum": 1e-3, "largest_of_a_frame": 2e-4, "frames_over": 1, "loosest_tolerance": 0.1,
        "solves": 9, "rejected": 1},
      "mesh_error": {"rms": 0.001, "largest": 0.004, "largest_motion": 0.2, "frames": 6,
        "untrusted": 1},
      "damped": 3.5, "outside_fit": 12,
      "long_steps": [3, 7],
      "stage_seconds": {"read": 1, "voxelize": 2, "setup": 3, "steps": 4, "write": 5},
      "ms_per_step": {"median": 3, "p95": 4.8}, "peak_memory_bytes": 123456789012,
      "notes": ["band is taken by its law"], "warnings": ["nothing moved"], "command": "elastogen animate cat.obj",
      "commit": "abc123"})");
  EXPECT_EQ(written(report), expected);
}

/// A step of a body of 2 kg that is pushed by a floor, rubs, and loses energy.
StepLedger falling_step() {
  StepLedger step;
  step.known = true;
  step.about = {1, 2, 3};
  step.start.momentum.linear = {0, -4, 0};
  step.end.momentum.linear = {0, -1, 0};
  step.start.energy = {.kinetic = 4, .elastic = 0.5, .gravity = 10};
  step.end.energy = {.kinetic = 0.25, .elastic = 3, .gravity = 9, .contact = 0.5, .bonds = 0.125};
  step.done.gravity.linear = {0, -2, 0};
  step.done.contact.linear = {0, 5, 0};
  step.done.damped = 0.5;
  step.done.rubbed = 0.25;
  step.done.colliders = 0.125;
  step.done.residual = 0.0625;
  step.correction = -0.03125;
  return step;
}

TEST(ReportFile, HasTheLedgerOfTheRun) {
  RunReport report;
  EXPECT_FALSE(written(report).contains("ledger"));
  report.ledger.add(falling_step());
  const Json ledger = written(report)["ledger"], &energy = ledger["energy"];
  EXPECT_EQ(ledger["steps"], 1);
  EXPECT_EQ(ledger["about"], Json({1, 2, 3}));
  EXPECT_EQ(ledger["momentum"]["contact"], Json({0, 5, 0}));
  EXPECT_EQ(ledger["momentum"]["unaccounted"], Json({0, 0, 0}));
  EXPECT_EQ(ledger["momentum"]["largest"], 4);
  EXPECT_EQ(energy["start"]["total"], 14.5);
  EXPECT_EQ(energy["end"]["total"], 12.875);
  EXPECT_EQ(energy["friction"], 0.125);
  // 14.5 - 12.875 + 0.125 - 0.5 - 0.125
  EXPECT_EQ(energy["numerical"], 1.125);
  EXPECT_EQ(energy["of_residual"], 0.0625);
  EXPECT_EQ(energy["of_correction"], -0.03125);
  EXPECT_EQ(energy["largest_rise"], 0);
}

TEST(ReportFile, StaysReadableWithNumbersAndNamesThatJsonLacks) {
  RunReport report;
  report.worst_residual = std::numeric_limits<double>::infinity();
  report.asset.path = "bad \xff name";
  EXPECT_TRUE(written(report)["worst_residual"].is_null());
}

TEST(Quantile, InterpolatesBetweenNeighbours) {
  EXPECT_EQ(quantile({}, 0.5), 0);
  EXPECT_EQ(quantile({3}, 0.95), 3);
  EXPECT_EQ(quantile({4, 1, 2, 3}, 0), 1);
  EXPECT_EQ(quantile({4, 1, 2, 3}, 0.5), 2.5);
  EXPECT_EQ(quantile({4, 1, 2, 3}, 1), 4);
  EXPECT_THROW(quantile({1}, 1.5), Error);
}

TEST(PeakMemory, IsAtLeastWhatIsTouched) {
  const int64_t bytes = int64_t{256} << 20;
  const std::vector<char> block(size_t(bytes), 1);
  EXPECT_GE(peak_memory_bytes(), std::count(block.begin(), block.end(), 1));
}

}  // namespace
}  // namespace elastogen
