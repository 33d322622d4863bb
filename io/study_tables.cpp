// SPDX-License-Identifier: Apache-2.0
#include "io/study_tables.hpp"

#include "core/error.hpp"
#include "io/html_table.hpp"
#include "io/study_errors.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

using Runs = std::vector<const StudyRun*>;

/// The runs of each pair of solver and element, in the order of their first run.
std::vector<Runs> by_solver(const std::vector<StudyRun>& runs) {
  std::vector<Runs> groups;
  for (const StudyRun& run : runs) {
    const auto same = [&](const Runs& group) {
      return group[0]->solver == run.solver && group[0]->element == run.element;
    };
    const auto found = std::find_if(groups.begin(), groups.end(), same);
    if (found != groups.end())
      found->push_back(&run);
    else
      groups.push_back({&run});
  }
  return groups;
}

/// The smallest finite error of the runs, with the run that has it.
std::string least_error(const Runs& runs, ErrorColumn column) {
  const StudyRun* best = nullptr;
  double least = INFINITY;
  for (const StudyRun* run : runs) {
    const ErrorSeries* series = error_series(*run, column);
    if (!series || !(series->max < least)) continue;
    least = series->max;
    best = run;
  }
  return best ? concat(number_cell(least), " (", best->name, ')') : kNoCell;
}

std::string fastest(const Runs& runs) {
  const StudyRun* best = nullptr;
  for (const StudyRun* run : runs)
    if (std::isfinite(run->step_ms.median) && (!best || run->step_ms.median < best->step_ms.median))
      best = run;
  return best ? concat(number_cell(best->step_ms.median), " (", best->name, ')') : kNoCell;
}

std::vector<std::string> summary_row(const Runs& runs) {
  double worst_residual = 0, least_converged = 1;
  for (const StudyRun* run : runs) {
    // a residual that is not a number is the worst
    if (!(run->worst_residual <= worst_residual)) worst_residual = run->worst_residual;
    if (!(run->converged_share >= least_converged)) least_converged = run->converged_share;
  }
  std::vector<std::string> row = {runs[0]->solver, runs[0]->element, std::to_string(runs.size()),
                                  fastest(runs)};
  for (const ErrorColumn column : kErrorColumns) row.push_back(least_error(runs, column));
  row.push_back(number_cell(100 * least_converged));
  row.push_back(number_cell(worst_residual));
  return row;
}

std::string budget_of(const StudyRun& run) {
  if (run.tolerance) return concat("tolerance ", number_cell(*run.tolerance));
  if (!run.loops) return kNoCell;
  return concat(run.loops->outer, " x ", run.loops->inner, " loops, ", run.loops->modes, " modes");
}

/// A count of the whole run, divided by its steps.
std::string a_step(int64_t count, const StudyRun& run) {
  return run.steps > 0 ? number_cell(double(count) / double(run.steps)) : kNoCell;
}

std::vector<std::string> run_row(const StudyRun& run) {
  return {run.name,
          run.solver,
          run.element,
          number_cell(run.h),
          number_cell(run.dt),
          budget_of(run),
          std::to_string(run.steps),
          run.voxels > 0 ? std::to_string(run.voxels) : kNoCell,
          std::to_string(run.elements),
          std::to_string(run.dofs),
          a_step(run.outer, run),
          a_step(run.inner, run),
          number_cell(100 * run.converged_share),
          number_cell(run.worst_residual),
          number_cell(run.min_j)};
}

std::vector<std::string> error_row(const StudyRun& run) {
  const StepTime& t = run.step_ms;
  // time and memory of the run
  std::vector<std::string> row = {
      run.name,
      number_cell(t.median),
      concat(number_cell(t.lower_quartile), " ... ", number_cell(t.upper_quartile)),
      number_cell(double(run.state_bytes) / 1e6),
      number_cell(run.state_copies_per_second),
      number_cell(t.median / 1000 * run.state_copies_per_second)};
  // both families of errors; a dash for each number that the run does not have
  for (const ErrorFamily family : {ErrorFamily::kSolver, ErrorFamily::kDiscretisation}) {
    const std::optional<StudyErrors>& errors = errors_of(run, family);
    const bool grid = family == ErrorFamily::kDiscretisation;
    if (!errors) {
      row.insert(row.end(), grid ? 6 : 5, kNoCell);
      continue;
    }
    for (const double value :
         {errors->step.max, errors->free_run.max, errors->iou, errors->energy_drift})
      row.push_back(number_cell(value));
    row.push_back(errors->reference);
    if (grid)
      row.push_back(errors->reference_change ? number_cell(*errors->reference_change) : kNoCell);
  }
  return row;
}

std::string time_table(const std::vector<TimeToError>& times, ErrorFamily family) {
  HtmlTable table;
  table.caption = "Time to " + family_title(family) +
                  ": median time of a step of the cheapest run at or below the error";
  table.heads = {"solver", "error of", "reference"};
  for (const TimeToError& time : times) {
    if (time.family != family) continue;
    std::vector<std::string> row = {time.solver, measure_title(time.measure), time.reference};
    for (const ReachedError& level : time.levels)
      row.push_back(level.ms ? concat(number_cell(*level.ms), " (", level.run, ')')
                             : "not reached");
    // heads are the levels of the first row; all rows have the same levels
    if (table.rows.empty())
      for (const ReachedError& level : time.levels)
        table.heads.push_back("to " + number_cell(level.error) + " [ms a step]");
    table.rows.push_back(row);
  }
  return table.rows.empty() ? "" : html_table(table);
}

}  // namespace

std::string summary_table(const std::vector<StudyRun>& runs) {
  HtmlTable table;
  table.groups = {{"", 4},
                  {"least solver error [-]", 2},
                  {"least discretisation error [-]", 2},
                  {"of all runs", 2}};
  table.heads = {"solver", "element", "runs", "fastest [ms a step]"};
  for (const ErrorColumn column : kErrorColumns)
    table.heads.push_back(measure_title(column.measure));
  table.heads.insert(table.heads.end(), {"least converged share [%]", "worst residual [-]"});
  for (const Runs& group : by_solver(runs)) table.rows.push_back(summary_row(group));
  return table.rows.empty() ? "" : html_table(table);
}

std::string time_to_error_tables(const std::vector<TimeToError>& times) {
  return time_table(times, ErrorFamily::kSolver) + time_table(times, ErrorFamily::kDiscretisation);
}

std::string run_table(const std::vector<StudyRun>& runs) {
  HtmlTable table;
  table.caption = "Runs: what was solved, and how well";
  table.heads = {"run",           "solver",
                 "element",       "h [m]",
                 "dt [s]",        "budget",
                 "steps",         "voxels",
                 "elements",      "free dofs",
                 "outer a step",  "inner a step",
                 "converged [%]", "worst residual [-]",
                 "min J [-]"};
  for (const StudyRun& run : runs) table.rows.push_back(run_row(run));
  return table.rows.empty() ? "" : html_table(table);
}

std::string error_table(const std::vector<StudyRun>& runs) {
  HtmlTable table;
  table.caption = "Runs: time and errors";
  table.groups = {
      {"", 1}, {"time of a step and state", 5}, {"solver error", 5}, {"discretisation error", 6}};
  table.heads = {"run",        "median [ms]",        "quartiles [ms]",
                 "state [MB]", "state copies [1/s]", "step [state copies]"};
  for (int family = 0; family < 2; ++family)
    table.heads.insert(table.heads.end(), {"each step, max [-]", "free run, max [-]", "IoU [-]",
                                           "energy drift [-]", "reference"});
  table.heads.push_back("its own change [-]");
  for (const StudyRun& run : runs) table.rows.push_back(error_row(run));
  return table.rows.empty() ? "" : html_table(table);
}

std::string figure_table(const std::vector<StudyFigure>& figures) {
  HtmlTable table;
  table.heads = {"figure", "value", "reference", "tolerance", "unit", "pass"};
  for (const StudyFigure& f : figures)
    table.rows.push_back({f.name, number_cell(f.value), number_cell(f.reference),
                          number_cell(f.tolerance), f.unit, f.pass ? "yes" : "NO"});
  return table.rows.empty() ? "" : html_table(table);
}

std::string family_title(ErrorFamily family) {
  return family == ErrorFamily::kSolver ? "solver error" : "discretisation error";
}

std::string measure_title(ErrorMeasure measure) {
  return measure == ErrorMeasure::kStep ? "each step" : "free run";
}

}  // namespace elastogen
