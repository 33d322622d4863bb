// SPDX-License-Identifier: Apache-2.0
#include "io/study_plots.hpp"

#include "core/error.hpp"
#include "io/html_table.hpp"
#include "io/study_errors.hpp"
#include "io/study_tables.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

namespace elastogen {
namespace {

/// "Solver error, free run"; without the capital in the middle of a sentence.
std::string column_title(ErrorColumn column) {
  return family_title(column.family) + ", " + measure_title(column.measure);
}

std::string sentence(std::string text) {
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') text[0] = char(text[0] - 'a' + 'A');
  return text;
}

/// Errors over times of the runs of one solver, element and reference, fastest first.
struct ErrorTimeLine {
  std::string solver, element, reference;
  std::vector<const StudyRun*> runs;
};

std::vector<ErrorTimeLine> error_time_lines(const std::vector<StudyRun>& runs, ErrorColumn column) {
  std::vector<ErrorTimeLine> lines;
  for (const StudyRun& run : runs) {
    const std::optional<StudyErrors>& errors = errors_of(run, column.family);
    if (!errors) continue;
    const auto same = [&](const ErrorTimeLine& line) {
      return line.solver == run.solver && line.element == run.element &&
             line.reference == errors->reference;
    };
    auto line = std::find_if(lines.begin(), lines.end(), same);
    if (line == lines.end())
      line = lines.insert(line, {run.solver, run.element, errors->reference, {}});
    line->runs.push_back(&run);
  }
  // times that are not finite come last
  const auto faster = [](const StudyRun* a, const StudyRun* b) {
    return a->step_ms.median < b->step_ms.median ||
           (std::isnan(b->step_ms.median) && !std::isnan(a->step_ms.median));
  };
  for (ErrorTimeLine& line : lines) std::stable_sort(line.runs.begin(), line.runs.end(), faster);
  return lines;
}

PlotSeries error_time_series(const ErrorTimeLine& line, ErrorColumn column) {
  PlotSeries series;
  for (const StudyRun* run : line.runs) {
    series.x.push_back(run->step_ms.median);
    series.y.push_back(error_series(*run, column)->max);
    series.labels.push_back(concat(run->name, ": ", number_cell(series.x.back()), " ms, ",
                                   number_cell(series.y.back())));
  }
  return series;
}

std::string error_time_figure(const std::vector<StudyRun>& runs, ErrorColumn column) {
  const std::vector<ErrorTimeLine> lines = error_time_lines(runs, column);
  if (lines.empty()) return "";
  LinePlot plot{sentence(column_title(column)) + ", against time",
                {"median time of a step [ms]", true},
                {column_title(column) + ", max [-]", true},
                {}};
  const bool one_reference =
      std::all_of(lines.begin(), lines.end(),
                  [&](const ErrorTimeLine& line) { return line.reference == lines[0].reference; });
  for (const ErrorTimeLine& line : lines) {
    plot.series.push_back(error_time_series(line, column));
    plot.series.back().name =
        concat(line.solver, ", ", line.element, one_reference ? "" : ", against " + line.reference);
  }
  return html_figure(line_plot(plot),
                     concat("Each point is a run; down and to the left is better.",
                            one_reference ? " Reference: " + lines[0].reference + '.' : ""));
}

bool same_plot(const StudySweep& a, const StudySweep& b) {
  return a.variable == b.variable && a.unit == b.unit && a.family == b.family &&
         a.measure == b.measure;
}

/// The points of the sweeps; each but the first with the order from the point above it.
std::string sweep_table(const std::vector<StudySweep>& sweeps) {
  HtmlTable table;
  table.heads = {"line", concat(sweeps[0].variable, " [", sweeps[0].unit, ']'),
                 column_title({sweeps[0].family, sweeps[0].measure}) + ", max [-]",
                 "order from the row above [-]"};
  for (const StudySweep& sweep : sweeps)
    for (size_t k = 0; k < sweep.x.size(); ++k) {
      const double order = k == 0 ? NAN
                                  : observed_order({sweep.x[k - 1], sweep.x[k]},
                                                   {sweep.error[k - 1], sweep.error[k]});
      table.rows.push_back({sweep.name, number_cell(sweep.x[k]), number_cell(sweep.error[k]),
                            std::isfinite(order) ? number_cell(order) : kNoCell});
    }
  return table.rows.empty() ? "" : html_table(table);
}

/// @param sweeps  sweeps of one plot, at least one.
std::string sweep_figure(const std::vector<StudySweep>& sweeps) {
  const std::string title = column_title({sweeps[0].family, sweeps[0].measure});
  LinePlot plot{concat(sentence(title), ", against ", sweeps[0].variable),
                {concat(sweeps[0].variable, " [", sweeps[0].unit, ']'), true},
                {title + ", max [-]", true},
                {}};
  for (const StudySweep& sweep : sweeps) {
    const std::string order =
        std::isfinite(sweep.order) ? concat("order ", number_cell(sweep.order), ": ") : "";
    plot.series.push_back({order + sweep.name, sweep.x, sweep.error, {}});
  }
  return html_figure(line_plot(plot), "Orders are slopes of least squares over all points.") +
         sweep_table(sweeps);
}

using SeriesOf = std::function<const std::vector<double>*(const StudyRun&)>;

/// Times at which the steps of a series end [s].
std::vector<double> step_ends(const StudyRun& run, size_t steps) {
  std::vector<double> times(steps);
  for (size_t k = 0; k < steps; ++k) times[k] = double(k + 1) * run.dt;
  return times;
}

/// A line for each run that has the series; "" if none has it.
std::string time_figure(const std::vector<StudyRun>& runs, const std::string& title,
                        const PlotAxis& axis, const SeriesOf& series_of) {
  LinePlot plot{title, {"time at the end of the step [s]", false}, axis, {}};
  for (const StudyRun& run : runs) {
    const std::vector<double>* series = series_of(run);
    if (!series || series->empty()) continue;
    plot.series.push_back({run.name, step_ends(run, series->size()), *series, {}});
  }
  return plot.series.empty() ? "" : html_figure(line_plot(plot), "A line for each run.");
}

std::string energy_parts_figure(const StudyRun& run) {
  const EnergySeries& e = run.energy;
  const std::vector<double> times = step_ends(run, e.total.size());
  const LinePlot plot{"Energies of " + run.name,
                      {"time at the end of the step [s]", false},
                      {"energy [J]", false},
                      {{"kinetic", times, e.kinetic, {}},
                       {"elastic", times, e.elastic, {}},
                       {"hourglass", times, e.hourglass, {}},
                       {"gravity", times, e.gravity, {}},
                       {"contact", times, e.contact, {}},
                       {"total", times, e.total, {}}}};
  return html_figure(line_plot(plot), "Parts of the energy at the end of each step.");
}

}  // namespace

std::string error_time_figures(const std::vector<StudyRun>& runs) {
  std::string figures;
  for (const ErrorColumn column : kErrorColumns) figures += error_time_figure(runs, column);
  return figures;
}

std::string sweep_figures(const std::vector<StudySweep>& sweeps) {
  std::vector<std::vector<StudySweep>> plots;
  for (const StudySweep& sweep : sweeps) {
    const auto same = [&](const std::vector<StudySweep>& plot) {
      return same_plot(plot[0], sweep);
    };
    const auto plot = std::find_if(plots.begin(), plots.end(), same);
    if (plot != plots.end())
      plot->push_back(sweep);
    else
      plots.push_back({sweep});
  }
  std::string figures;
  for (const std::vector<StudySweep>& plot : plots) figures += sweep_figure(plot);
  return figures;
}

std::string residual_figure(const std::vector<StudyRun>& runs) {
  return time_figure(runs, "Residual of each step", {"residual [-]", true},
                     [](const StudyRun& run) { return &run.residual; });
}

std::string energy_figures(const std::vector<StudyRun>& runs) {
  const std::string total = time_figure(runs, "Total energy", {"total energy [J]"},
                                        [](const StudyRun& run) { return &run.energy.total; });
  std::string parts;
  for (const StudyRun& run : runs)
    if (!run.energy.total.empty()) parts += energy_parts_figure(run);
  if (parts.empty()) return total;
  return concat(total, "<details>\n<summary>Parts of the energy, run by run</summary>\n", parts,
                "</details>\n");
}

std::string error_series_figures(const std::vector<StudyRun>& runs) {
  std::string figures;
  for (const ErrorColumn column : kErrorColumns) {
    const std::string title = column_title(column);
    figures += time_figure(runs, sentence(title) + ", over the run", {title + " [-]", true},
                           [&](const StudyRun& run) {
                             const ErrorSeries* series = error_series(run, column);
                             return series ? &series->steps : nullptr;
                           });
  }
  return figures;
}

std::string overlay_figures(const std::vector<ShapeOverlay>& overlays) {
  std::string figures;
  for (const ShapeOverlay& overlay : overlays) {
    const OutlinePlot plot{overlay.title, overlay.horizontal + " [m]", overlay.vertical + " [m]",
                           overlay.outlines};
    figures += html_figure(outline_plot(plot), concat("At ", number_cell(overlay.time),
                                                      " s. Both axes have one scale."));
  }
  return figures;
}

}  // namespace elastogen
