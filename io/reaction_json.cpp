// SPDX-License-Identifier: Apache-2.0
#include "io/reaction_json.hpp"

namespace elastogen {

nlohmann::ordered_json reactions_json(const std::vector<Reaction>& reactions,
                                      const std::vector<std::string>& names) {
  auto list = nlohmann::ordered_json::array();
  for (size_t h = 0; h < reactions.size(); ++h) {
    nlohmann::ordered_json one;
    if (!names.empty()) one["holder"] = names[h];
    one["force"] = reactions[h].force;
    one["moment"] = reactions[h].moment;
    one["about"] = reactions[h].about;
    list.push_back(std::move(one));
  }
  return list;
}

}  // namespace elastogen
