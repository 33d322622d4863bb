// SPDX-License-Identifier: Apache-2.0
#include "io/study_errors.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace elastogen {
namespace {

/// The entry of a reference and solver in the list; appended if there is none.
TimeToError& entry_of(std::vector<TimeToError>& list, const TimeToError& wanted) {
  const auto same = [&](const TimeToError& t) {
    return t.family == wanted.family && t.measure == wanted.measure &&
           t.reference == wanted.reference && t.solver == wanted.solver;
  };
  const auto found = std::find_if(list.begin(), list.end(), same);
  return found != list.end() ? *found : list.emplace_back(wanted);
}

void take_if_cheaper(ReachedError& reached, const StudyRun& run, double error) {
  if (!(error <= reached.error) || (reached.ms && run.step_ms.median >= *reached.ms)) return;
  reached.run = run.name;
  reached.ms = run.step_ms.median;
}

bool equal_lengths(const EnergySeries& e) {
  const size_t steps = e.total.size();
  return e.kinetic.size() == steps && e.elastic.size() == steps && e.hourglass.size() == steps &&
         e.gravity.size() == steps && e.contact.size() == steps;
}

}  // namespace

std::string_view family_name(ErrorFamily family) {
  return family == ErrorFamily::kSolver ? "solver_error" : "discretisation_error";
}

std::string_view measure_name(ErrorMeasure measure) {
  return measure == ErrorMeasure::kStep ? "step" : "free_run";
}

const std::optional<StudyErrors>& errors_of(const StudyRun& run, ErrorFamily family) {
  return family == ErrorFamily::kSolver ? run.solver_error : run.discretisation_error;
}

const ErrorSeries* error_series(const StudyRun& run, ErrorColumn column) {
  const std::optional<StudyErrors>& errors = errors_of(run, column.family);
  if (!errors) return nullptr;
  return column.measure == ErrorMeasure::kStep ? &errors->step : &errors->free_run;
}

std::vector<TimeToError> times_to_error(const std::vector<StudyRun>& runs) {
  std::vector<TimeToError> list;
  for (const ErrorColumn column : kErrorColumns)
    for (const StudyRun& run : runs) {
      const ErrorSeries* series = error_series(run, column);
      if (!series) continue;
      TimeToError& entry = entry_of(list, {column.family,
                                           column.measure,
                                           errors_of(run, column.family)->reference,
                                           run.solver,
                                           {{1e-1}, {1e-2}, {1e-3}, {1e-4}}});
      if (!std::isfinite(run.step_ms.median)) continue;
      for (ReachedError& level : entry.levels) take_if_cheaper(level, run, series->max);
    }
  return list;
}

double observed_order(const std::vector<double>& x, const std::vector<double>& error) {
  ELASTOGEN_CHECK(x.size() == error.size(), "an order needs an error for each x, got ", x.size(),
                  " x and ", error.size(), " errors");
  std::vector<double> a, b;
  for (size_t k = 0; k < x.size(); ++k) {
    const double log_x = std::log(x[k]), log_error = std::log(error[k]);
    if (!std::isfinite(log_x) || !std::isfinite(log_error)) continue;
    a.push_back(log_x);
    b.push_back(log_error);
  }
  const double n = double(a.size());
  double mean_a = 0, mean_b = 0, aa = 0, ab = 0;
  for (size_t k = 0; k < a.size(); ++k) {
    mean_a += a[k] / n;
    mean_b += b[k] / n;
  }
  for (size_t k = 0; k < a.size(); ++k) {
    aa += (a[k] - mean_a) * (a[k] - mean_a);
    ab += (a[k] - mean_a) * (b[k] - mean_b);
  }
  const bool differ = std::any_of(a.begin(), a.end(), [&](double value) { return value != a[0]; });
  return differ ? ab / aa : std::numeric_limits<double>::quiet_NaN();
}

std::string contradiction_in(const StudyResult& result) {
  std::set<std::string> names;
  for (const StudyRun& run : result.runs) {
    if (!names.insert(run.name).second) return concat("two runs have the name '", run.name, '\'');
    if (!equal_lengths(run.energy))
      return concat("the energies of run '", run.name, "' have different lengths");
  }
  for (const StudySweep& sweep : result.sweeps)
    if (sweep.x.size() != sweep.error.size())
      return concat("sweep '", sweep.name, "' has ", sweep.x.size(), " x and ", sweep.error.size(),
                    " errors");
  return "";
}

}  // namespace elastogen
