// SPDX-License-Identifier: Apache-2.0
// JSON from text, in one place: the parser adds seconds to the build of each source with it.

#pragma once

#include <nlohmann/json_fwd.hpp>

#include <string_view>

namespace elastogen {

/// The value of a text, keys in the text's order.
/// @throws nlohmann::json::exception where it is no JSON.
nlohmann::ordered_json parsed_json(std::string_view text);

/// The value of a text, keys in alphabetical order.
nlohmann::json parsed_sorted_json(std::string_view text);

}  // namespace elastogen
