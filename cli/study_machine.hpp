// SPDX-License-Identifier: Apache-2.0
// What a study says of the machine that it ran on.

#pragma once

#include "io/study_result.hpp"

namespace elastogen {

/// Model of the processor, cores, memory, and the rate of a parallel copy of arrays that no cache
/// holds (bytes read and written, median of several).
StudyMachine this_machine();

/// Copies of so many bytes a second by all threads, source and target each reused: as fast as the
/// caches allow.
double copies_per_second(int64_t bytes);

/// The present date and time, UTC, ISO 8601 to the second.
std::string utc_date();

}  // namespace elastogen
