// SPDX-License-Identifier: Apache-2.0
// The result of a study as study.json and study.csv (docs/study.md).

#pragma once

#include "io/study_result.hpp"

namespace elastogen {

/// `version` of study.json; readers refuse any other.
inline constexpr int64_t kStudyVersion = 1;

/// The result as JSON. Numbers read back as the same bits; "nan", "inf" and "-inf" stand for those
/// that are not finite. Bytes that are not UTF-8 become U+FFFD.
/// @throws Error (usage) if the result contradicts itself (contradiction_in).
std::string study_json(const StudyResult& result);

/// The runs as CSV (RFC 4180 with line feeds): a line of heads with units, then a line for each
/// run. Numbers as in exact_number; values that a run does not have are empty.
std::string study_csv(const std::vector<StudyRun>& runs);

/// Writes study_json and study_csv, each under a temporary name first.
/// @throws Error (resources) if the disk refuses it; (usage) as study_json.
void write_study_json(const std::string& path, const StudyResult& result);
void write_study_csv(const std::string& path, const StudyResult& result);

/// Reads a file of write_study_json.
/// @throws Error (asset) with file and place: a file that cannot be read or is larger than 256 MiB,
///         text that is no JSON, another format or version, a field that is missing, unknown or of
///         another type, a contradiction (contradiction_in).
StudyResult read_study(const std::string& path);

/// Reads a study from text. @param name  of the file, for messages.
StudyResult study_from_json(std::string_view text, const std::string& name);

}  // namespace elastogen
