// SPDX-License-Identifier: Apache-2.0
// SIGINT and SIGTERM: finish the step, write what there is, exit with 130 or 143.

#pragma once

namespace elastogen {

/// From now on the first SIGINT or SIGTERM is remembered, and a second one ends the process at once
/// (outputs are whole or absent all the same: they are renamed into place).
void watch_signals();

/// The remembered signal, 0 for none. The exit code is 128 plus it.
int pending_signal();

}  // namespace elastogen
