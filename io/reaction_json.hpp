// SPDX-License-Identifier: Apache-2.0
// Reactions of pins and moves as JSON (docs/formats.md, log and report).

#pragma once

#include "core/holder.hpp"

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace elastogen {

/// A list of objects, one a holder. @param names  of the holders; empty: without names.
nlohmann::ordered_json reactions_json(const std::vector<Reaction>& reactions,
                                      const std::vector<std::string>& names = {});

}  // namespace elastogen
