// SPDX-License-Identifier: Apache-2.0
#include "io/study_page.hpp"

#include "core/error.hpp"
#include "io/html_table.hpp"
#include "io/safe_file.hpp"
#include "io/study_errors.hpp"
#include "io/study_plots.hpp"
#include "io/study_tables.hpp"
#include "io/text_format.hpp"

namespace elastogen {
namespace {

constexpr const char* kPageStyle = R"(:root{color-scheme:light dark}
body{font:15px/1.45 sans-serif;margin:2em auto;padding:0 1em;max-width:1200px;
color:#1b1b1b;background:#ffffff}
h1{font-size:1.6em}
h2{font-size:1.2em;margin-top:2em}
.table{overflow-x:auto}
table{border-collapse:collapse;font-size:13px;margin:1em 0}
caption{text-align:left;padding:.3em 0;font-weight:bold}
th,td{border:1px solid #c4c4c4;padding:.25em .5em;text-align:right;vertical-align:top;
overflow-wrap:break-word}
thead th{text-align:center;vertical-align:bottom}
tbody th{text-align:left;font-weight:normal;overflow-wrap:anywhere}
figure{margin:1em 0}
figcaption{font-size:13px;max-width:60em}
pre{overflow-x:auto;white-space:pre-wrap;overflow-wrap:anywhere;font-size:12px}
@media screen and (prefers-color-scheme:dark){
body{color:#e8e8e8;background:#181818}
th,td{border-color:#4a4a4a}
}
@media print{
@page{size:A4 landscape;margin:12mm}
body{margin:0;max-width:none;font-size:10pt;color:#000000;background:#ffffff}
table{font-size:6.5pt}
th,td{padding:.15em .3em}
.table{overflow-x:visible}
.plot{width:auto;max-height:76mm}
figure,tr{break-inside:avoid}
h2,caption{break-after:avoid}
}
)";

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
  return concat(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n<title>Study of ",
      markup_text(result.header.scene), "</title>\n<style>\n", kPageStyle, plot_style(),
      "</style>\n</head>\n<body>\n", introduction(result.header),
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
      html_section("Runs", run_table(runs) + error_table(runs)), foot(result.header),
      "</body>\n</html>\n");
}

void write_study_page(const std::string& path, const StudyResult& result) {
  write_file(path, study_page(result));
}

}  // namespace elastogen
