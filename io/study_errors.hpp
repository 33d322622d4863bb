// SPDX-License-Identifier: Apache-2.0
// What follows from the runs of a study: its order of convergence, what an error costs.

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
/// One of their series. @return nullptr where the run has no errors of the family.
const ErrorSeries* error_series(const StudyRun& run, ErrorColumn column);

/// For each family, measure, reference and solver, in the order in which the runs have them, the
/// run of smallest median step time whose largest error is at most 1e-1, 1e-2, 1e-3, 1e-4. A run
/// whose error or time is no finite number is not counted; of equal times the first run wins.
std::vector<TimeToError> times_to_error(const std::vector<StudyRun>& runs);

/// Slope of the straight line of least squares through (log x, log error). Points of which one
/// number is not positive and finite are left out.
/// @return NaN unless two points differ in x.
/// @throws Error if x and error have different lengths.
double observed_order(const std::vector<double>& x, const std::vector<double>& error);

/// What contradicts itself: two runs of one name, energies or a sweep of different lengths.
/// @return "" where nothing does.
std::string contradiction_in(const StudyResult& result);

}  // namespace elastogen
