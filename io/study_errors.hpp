// SPDX-License-Identifier: Apache-2.0
// Results derived from the runs of a study: order of convergence, and the time that an error needs.

#pragma once

#include "io/study_result.hpp"

namespace elastogen {

/// "solver_error", "discretisation_error".
std::string_view family_name(ErrorFamily family);
/// "step", "free_run".
std::string_view measure_name(ErrorMeasure measure);

/// One of the four series of errors that a run may have.
struct ErrorColumn {
  ErrorFamily family;
  ErrorMeasure measure;
};

inline constexpr ErrorColumn kErrorColumns[] = {
    {ErrorFamily::kSolver, ErrorMeasure::kStep},
    {ErrorFamily::kSolver, ErrorMeasure::kFreeRun},
    {ErrorFamily::kDiscretisation, ErrorMeasure::kStep},
    {ErrorFamily::kDiscretisation, ErrorMeasure::kFreeRun}};

/// The errors of a family, if the run has them.
const std::optional<StudyErrors>& errors_of(const StudyRun& run, ErrorFamily family);
/// The error series of a column. @return nullptr if the run has no errors of the family.
const ErrorSeries* error_series(const StudyRun& run, ErrorColumn column);

/// For each family, measure, reference and solver, in the order of the runs: the run of smallest
/// median step time whose largest error is at most 1e-1, 1e-2, 1e-3, 1e-4. Runs whose error or time
/// is not finite do not count; of equal times the first run wins.
std::vector<TimeToError> times_to_error(const std::vector<StudyRun>& runs);

/// Slope of the least-squares line through (log x, log error). Points with a number that is not
/// positive and finite are left out.
/// @return NaN unless two points differ in x.
/// @throws Error if x and error have different lengths.
double observed_order(const std::vector<double>& x, const std::vector<double>& error);

/// Contradictions within a result: two runs of one name, energies or a sweep of different lengths.
/// @return "" if there is none.
std::string contradiction_in(const StudyResult& result);

}  // namespace elastogen
