// SPDX-License-Identifier: Apache-2.0
// The ledger of steps as JSON, for the log and the report (docs/formats.md). For sources that see the
// JSON library.

#pragma once

#include "core/holder.hpp"
#include "core/ledger.hpp"

#include <nlohmann/json.hpp>

namespace elastogen {

/// Momentum, energy and what changed them, in a step or in several.
nlohmann::ordered_json ledger_json(const StepLedger& ledger);
/// The same of a run, with the largest of its steps.
nlohmann::ordered_json ledger_json(const Ledger& ledger);

/// Reactions as a list of objects, one a holder. @param names  of the holders; empty: without names.
nlohmann::ordered_json reactions_json(const std::vector<Reaction>& reactions,
                                      const std::vector<std::string>& names = {});

}  // namespace elastogen
