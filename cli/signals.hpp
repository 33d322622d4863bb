// SPDX-License-Identifier: Apache-2.0
// SIGINT and SIGTERM: finish the step, write the results so far, exit with 130 or 143.

#pragma once

namespace elastogen {

/// After this call the first SIGINT or SIGTERM is remembered and a second one ends the process at
/// once. Output files are complete or absent even then, as they are renamed into place.
void watch_signals();

/// The remembered signal, 0 for none. The exit code is 128 plus the signal.
int pending_signal();

}  // namespace elastogen
