// SPDX-License-Identifier: Apache-2.0
// The machine on which a study runs.

#pragma once

#include "io/study_result.hpp"

namespace elastogen {

/// Processor model, cores, memory, and the rate of a parallel copy of arrays larger than any cache
/// (bytes read and written, median of several).
StudyMachine this_machine();

/// How often all threads together copy this many bytes in a second, each reusing its source and
/// target, so as fast as the caches allow.
double copies_per_second(int64_t bytes);

/// The present date and time, UTC, ISO 8601 to the second.
std::string utc_date();

}  // namespace elastogen
