// SPDX-License-Identifier: Apache-2.0
// Findings about an asset: how much each matters, what is done about it, how to change that.

#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace elastogen {

/// Something a reader, the check or the voxeliser noticed.
struct Finding {
  std::string what;  ///< id of its kind, e.g. "zero-area"
  int64_t count = 0;
  std::string text;  ///< a sentence for people
};

/// A warning changes the result: something is left out, joined, filled as layers, loose or guessed.
/// A note does not.
enum class Severity { kNote, kWarning };

std::string_view severity_name(Severity severity);

/// A kind of finding: a row of docs/findings.md.
struct FindingKind {
  std::string_view what;
  Severity severity;
  std::string_view done;    ///< what is done about it
  std::string_view change;  ///< how the user changes that, "" where nothing is needed
};

/// Every kind that the program makes (tests/python/test_findings.py).
std::span<const FindingKind> finding_kinds();

/// @throws Error for an id without a row.
const FindingKind& kind_of(const Finding& finding);

/// The line that all verbs print: id, count, text, what is done, how to change it.
std::string finding_line(const Finding& finding);

/// The lines of the findings of one severity, in their order.
std::vector<std::string> finding_lines(const std::vector<Finding>& findings, Severity severity);

}  // namespace elastogen
