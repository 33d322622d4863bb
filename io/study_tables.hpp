// SPDX-License-Identifier: Apache-2.0
// The tables of study.html. Every head has its unit; each family of errors has its own columns. A
// table without rows is "".

#pragma once

#include "io/study_result.hpp"

namespace elastogen {

/// A row for each solver and element: its fastest run and its smallest errors.
std::string summary_table(const std::vector<StudyRun>& runs);

/// One table for each family of errors.
std::string time_to_error_tables(const std::vector<TimeToError>& times);

/// A row for each run: problem, method, quality of the solution.
std::string run_table(const std::vector<StudyRun>& runs);

/// A row for each run: its time and its errors.
std::string error_table(const std::vector<StudyRun>& runs);

/// A row for each number with a known value.
std::string figure_table(const std::vector<StudyFigure>& figures);

/// "solver error", "discretisation error".
std::string family_title(ErrorFamily family);
/// "each step", "free run".
std::string measure_title(ErrorMeasure measure);

}  // namespace elastogen
