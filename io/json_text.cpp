// SPDX-License-Identifier: Apache-2.0
#include "io/json_text.hpp"

#include <nlohmann/json.hpp>

namespace elastogen {

nlohmann::ordered_json parsed_json(std::string_view text) {
  return nlohmann::ordered_json::parse(text);
}

nlohmann::json parsed_sorted_json(std::string_view text) {
  return nlohmann::json::parse(text);
}

}  // namespace elastogen
