// SPDX-License-Identifier: Apache-2.0
// The ledger of a run as text, which the commands print at its end.

#pragma once

#include "core/ledger.hpp"

#include <string>

namespace elastogen {

/// A few lines: energy at the start and at the end and where it went, momentum and what changed it.
/// Empty where the run has no ledger.
std::string ledger_lines(const Ledger& ledger);

}  // namespace elastogen
