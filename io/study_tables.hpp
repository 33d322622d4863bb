// SPDX-License-Identifier: Apache-2.0
// The tables of study.html. Every head has its unit; the two families of errors have columns of
// their own. Each is "" where it would have no rows.

#pragma once

#include "io/study_result.hpp"

namespace elastogen {

/// A row for each solver and element: its fastest run and its smallest errors.
std::string summary_table(const std::vector<StudyRun>& runs);

/// A table for each family.
std::string time_to_error_tables(const std::vector<TimeToError>& times);

/// A row a run: what was solved, how, and how well.
std::string run_table(const std::vector<StudyRun>& runs);

/// A row a run: its time beside its errors.
std::string error_table(const std::vector<StudyRun>& runs);

/// A row for each number that is known from elsewhere.
std::string figure_table(const std::vector<StudyFigure>& figures);

/// "solver error", "discretisation error".
std::string family_title(ErrorFamily family);
/// "each step", "free run".
std::string measure_title(ErrorMeasure measure);

}  // namespace elastogen
