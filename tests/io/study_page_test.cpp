// SPDX-License-Identifier: Apache-2.0
#include "io/study_page.hpp"

#include "io/study_tables.hpp"
#include "tests/io/markup_check.hpp"
#include "tests/io/study_example.hpp"
#include "tests/io/test_files.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace elastogen {
namespace {

/// Cells of the tables of a page, head rows included.
std::vector<std::vector<std::string>> rows_of(const std::string& html) {
  std::vector<std::vector<std::string>> rows;
  for (const std::string& row : test::parts_between(html, "<tr>", "</tr>")) {
    rows.emplace_back();
    // a cell is the text between the end of its tag and the next tag
    for (const std::string& cell : test::parts_between(row, "<t", "</t"))
      rows.back().push_back(cell.substr(cell.find('>') + 1));
  }
  return rows;
}

TEST(StudyPage, IsWellFormedAndHasEverySection) {
  const std::string page = study_page(test::example_study());
  EXPECT_EQ(test::markup_fault(page), "");
  for (const char* heading : {"Summary", "Time to error", "Error against time", "Convergence",
                              "Residuals", "Errors over the run", "Energies", "Shapes",
                              "Figures with a reference", "Runs", "Machine and command"})
    test::expect_says(page, concat("<h2>", heading, "</h2>"));
  for (const char* text :
       {"AMD EPYC", "4 cores", "24 GiB", "23.75 GB/s", "abc123", "elastogen study beam.toml",
        "2026-11-22T10:00:00Z", "2 threads", "h = 0.03125", "order 2: quasi, voxel"})
    test::expect_says(page, text);
  // error against time and over the run: 4 each; one sweep, residuals, an overlay; energies in all
  // and of each of the four runs
  EXPECT_EQ(test::count_of(page, "<svg "), 4 + 4 + 1 + 1 + 1 + 1 + 4);
}

TEST(StudyPage, NeedsNothingFromElsewhere) {
  const std::string page = study_page(test::example_study());
  for (const char* part :
       {"<script", "<link", "<img", "<iframe", "src=", "href=", "url(", "@import"})
    EXPECT_EQ(page.find(part), std::string::npos) << part;
  // the one address is the name of SVG
  EXPECT_EQ(test::count_of(page, "http"), test::count_of(page, "<svg "));
  test::expect_says(page, "@media screen and (prefers-color-scheme:dark)");
  test::expect_says(page, "@media print");
}

TEST(StudyPage, EscapesEveryText) {
  StudyResult study = test::example_study();
  StudyHeader& header = study.header;
  const std::string& hostile = test::kHostile;
  // every text of the study is hostile
  for (std::string* text : {&header.scene, &header.scene_text, &header.command, &header.commit,
                            &header.date, &header.machine.cpu})
    *text = hostile;
  for (StudyRun& run : study.runs) {
    run.name += hostile;
    run.solver = run.element = hostile;
    for (std::optional<StudyErrors>* errors : {&run.solver_error, &run.discretisation_error})
      if (*errors) (*errors)->reference = hostile;
  }
  study.time_to_error = times_to_error(study.runs);
  StudySweep& sweep = study.sweeps[0];
  sweep.name = sweep.variable = sweep.unit = hostile;
  ShapeOverlay& overlay = study.overlays[0];
  overlay.title = overlay.horizontal = overlay.vertical = overlay.outlines[0].name = hostile;
  study.figures[0].name = study.figures[0].unit = hostile;

  // the page is well-formed and runs nothing
  const std::string page = study_page(study);
  EXPECT_EQ(test::markup_fault(page), "");
  for (const char* part : {"<script", "<img", "\xff", "\x01"})
    EXPECT_EQ(page.find(part), std::string::npos) << part;
  EXPECT_EQ(test::count_of(page, "</style>"), 1);
  EXPECT_GE(test::count_of(page, "&lt;script&gt;"), 50);
}

TEST(StudyPage, ShowsAnEmptyStudy) {
  const std::string page = study_page({});
  EXPECT_EQ(test::markup_fault(page), "");
  test::expect_says(page, "The study has no runs.");
  EXPECT_EQ(page.find("<svg "), std::string::npos);
  EXPECT_EQ(page.find("<table>"), std::string::npos);
}

TEST(StudyPage, CountsWhatThePlotsLeaveOut) {
  StudyResult study = test::example_study();
  EXPECT_EQ(study_page(study).find("Left out"), std::string::npos);
  study.runs[0].residual = {0, std::numeric_limits<double>::quiet_NaN()};
  study.runs[1].energy.total[0] = std::numeric_limits<double>::infinity();
  const std::string page = study_page(study);
  EXPECT_EQ(test::markup_fault(page), "");
  EXPECT_EQ(test::count_of(page, "Left out: 2 points without a place"), 1);
  // in the plot of all runs, and in that of this one
  EXPECT_EQ(test::count_of(page, "Left out: 1 point without a place"), 2);
}

TEST(StudyPage, ShowsOneRunWithoutErrorsAndAStudyOfNoNumbers) {
  StudyResult study;
  study.runs = {StudyRun()};
  EXPECT_EQ(test::markup_fault(study_page(study)), "");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  StudyRun& run = study.runs[0];
  run.h = run.dt = run.step_ms.median = run.worst_residual = run.min_j = nan;
  run.tolerance = run.state_copies_per_second = run.converged_share = nan;
  run.residual = {nan};
  run.solver_error = test::example_errors("none", nan);
  study.figures = {{"nothing", nan, nan, nan, "m", false}};
  study.sweeps = {
      {"nothing", "h", "m", ErrorFamily::kSolver, ErrorMeasure::kStep, {nan}, {nan}, nan}};
  EXPECT_EQ(test::markup_fault(study_page(study)), "");
}

TEST(StudyTables, KeepTheFamiliesInColumnsOfTheirOwn) {
  const std::string html = error_table(test::example_study().runs);
  test::expect_says(html,
                    "colspan=\"5\">solver error</th>"
                    "<th class=\"group\" colspan=\"6\">discretisation error</th>");
  const auto rows = rows_of(html);
  ASSERT_EQ(rows.size(), 6u);
  for (size_t k = 1; k < rows.size(); ++k) ASSERT_EQ(rows[k].size(), 17u);
  EXPECT_EQ(rows[1][6], "each step, max [-]");
  EXPECT_EQ(rows[1][11], "each step, max [-]");
  // 1.5 times the scale 2^-7, and 16 times that
  EXPECT_EQ(rows[2][6], "0.01172");
  EXPECT_EQ(rows[2][10], "newton 1e-12");
  EXPECT_EQ(rows[2][11], "0.1875");
  EXPECT_EQ(rows[2][15], "tet10 fine");
  EXPECT_EQ(rows[2][16], "0.0625");
  // 8 ms of 12500 copies a second are 100 copies
  EXPECT_EQ(rows[2][5], "100");
  for (size_t column = 6; column < 17; ++column) EXPECT_EQ(rows[5][column], "\xe2\x80\x93");
}

TEST(StudyTables, SayWhatAnErrorCostsAndWhatIsNotReached) {
  // errors of a step: quasi 1.2e-2 in 8 ms and 7.3e-4 in 16 ms, newton 3.7e-4 in 24 ms
  const auto rows = rows_of(time_to_error_tables(test::example_study().time_to_error));
  ASSERT_EQ(rows.size(), 10u);
  using Row = std::vector<std::string>;
  EXPECT_EQ(rows[0], (Row{"solver", "error of", "reference", "to 0.1 [ms a step]",
                          "to 0.01 [ms a step]", "to 0.001 [ms a step]", "to 0.0001 [ms a step]"}));
  EXPECT_EQ(rows[1], (Row{"quasi", "each step", "newton 1e-12", "8 (quasi 1e-2)", "16 (quasi 1e-3)",
                          "16 (quasi 1e-3)", "not reached"}));
  EXPECT_EQ(rows[2][5], "24 (newton 1e-3)");
}

TEST(StudyTables, SumUpEachSolverAndElement) {
  const auto rows = rows_of(summary_table(test::example_study().runs));
  ASSERT_EQ(rows.size(), 5u);
  using Row = std::vector<std::string>;
  EXPECT_EQ(rows[2], (Row{"quasi", "voxel", "2", "8 (quasi 1e-2)", "0.0007324 (quasi 1e-3)",
                          "0.001221 (quasi 1e-3)", "0.01172 (quasi 1e-3)", "0.01953 (quasi 1e-3)",
                          "50", "0.01562"}));
  EXPECT_EQ(rows[4][4], "\xe2\x80\x93");
}

TEST(StudyTables, ShowTheBudgetOfARun) {
  const auto rows = rows_of(run_table(test::example_study().runs));
  EXPECT_EQ(rows[1][5], "tolerance 0.007812");
  EXPECT_EQ(rows[4][5], "10 x 20 loops, 54 modes");
  EXPECT_EQ(rows[4][7], "\xe2\x80\x93");
  EXPECT_EQ(rows[1][10], "3.5");  // 7 outer iterations in two steps
}

TEST(StudyPage, IsWrittenWholeOrNotAtAll) {
  const test::TempFolder folder;
  const std::string path = folder.write("study.html", "old");
  StudyResult study = test::example_study();
  study.runs[1].name = study.runs[0].name;
  test::error_of([&] { write_study_page(path, study); }, ErrorKind::kUsage);
  EXPECT_EQ(std::filesystem::file_size(path), 3u);
  write_study_page(path, test::example_study());
  std::ifstream file(path);
  const std::string page{std::istreambuf_iterator<char>(file), {}};
  EXPECT_EQ(page, study_page(test::example_study()));
  test::error_of([&] { write_study_page("/nonexistent/x", {}); }, ErrorKind::kResources);
}

}  // namespace
}  // namespace elastogen
