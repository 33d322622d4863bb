// SPDX-License-Identifier: Apache-2.0
// The result of a study as a page: one HTML file with its style and plots in it. It has no scripts
// and loads nothing, and suits light and dark screens and paper.

#pragma once

#include "io/study_result.hpp"

namespace elastogen {

/// Tables and plots of the result, well-formed as XML; every text of the result is escaped.
/// Sections without content are left out.
/// @throws Error (usage) if the result contradicts itself (contradiction_in).
std::string study_page(const StudyResult& result);

/// Writes the page, under a temporary name first.
/// @throws Error (resources) if the disk refuses it; (usage) as study_page.
void write_study_page(const std::string& path, const StudyResult& result);

}  // namespace elastogen
