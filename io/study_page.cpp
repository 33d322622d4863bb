// SPDX-License-Identifier: Apache-2.0
#include "io/study_page.hpp"

#include "core/error.hpp"
#include "io/html_page.hpp"
#include "io/html_table.hpp"
#include "io/safe_file.hpp"
#include "io/study_errors.hpp"
#include "io/study_plots.hpp"
#include "io/study_tables.hpp"
#include "io/text_format.hpp"

namespace elastogen {
namespace {

std::string introduction(const StudyHeader& header) {
  return concat(
      "<h1>Study of ", markup_text(header.scene), "</h1>\n<p>", markup_text(header.date), ", ",
      header.threads, " threads, times are medians of ", header.repeats,
      " runs each. The <em>solver error</em> is the distance from the same grid solved to "
      "a tight tolerance, the <em>discretisation error</em> that from a converged mesh of "
      "another element; both are relative, weighted with the mass. <em>Each step</em> "
      "starts from the state of the reference, a <em>free run</em> only once.</p>\n");
}

std::string foot(const StudyHeader& header) {
  const StudyMachine& machine = header.machine;
  return concat("<footer>\n<h2>Machine and command</h2>\n<p>", markup_text(machine.cpu), ", ",
                machine.cores, " cores, ", number_cell(double(machine.memory_bytes) / (1 << 30)),
                " GiB of memory, ", number_cell(machine.copy_bandwidth / 1e9),
                " GB/s read and written by a copy; commit ", markup_text(header.commit),
                ".</p>\n<pre>", markup_text(header.command),
                "</pre>\n<details>\n<summary>The scene with all its keys</summary>\n<pre>",
                markup_text(header.scene_text), "</pre>\n</details>\n</footer>\n");
}

}  // namespace

std::string study_page(const StudyResult& result) {
  const std::string contradiction = contradiction_in(result);
  ELASTOGEN_CHECK(contradiction.empty(), "a study cannot be written: ", contradiction);
  const std::vector<StudyRun>& runs = result.runs;
  const std::string body =
      concat(introduction(result.header),
             html_section("Summary",
                          runs.empty() ? "<p>The study has no runs.</p>\n" : summary_table(runs)),
             html_section("Time to error", time_to_error_tables(result.time_to_error)),
             html_section("Error against time", error_time_figures(runs)),
             html_section("Convergence", sweep_figures(result.sweeps)),
             html_section("Residuals", residual_figure(runs)),
             html_section("Errors over the run", error_series_figures(runs)),
             html_section("Energies", energy_figures(runs)),
             html_section("Shapes", overlay_figures(result.overlays)),
             html_section("Figures with a reference", figure_table(result.figures)),
             html_section("Runs", run_table(runs) + error_table(runs)), foot(result.header));
  return html_page("Study of " + result.header.scene, body);
}

void write_study_page(const std::string& path, const StudyResult& result) {
  write_file(path, study_page(result));
}

}  // namespace elastogen
