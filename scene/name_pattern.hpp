// SPDX-License-Identifier: Apache-2.0
// Names of an asset's nodes, materials and attributes, and patterns of them.

#pragma once

#include <set>
#include <string>
#include <string_view>

namespace elastogen {

/// Whether a name matches a pattern, in which * stands for any letters or none.
bool matches(std::string_view pattern, std::string_view name);

/// The same for attributes: without regard to case and to an underscore in front.
bool matches_attribute(std::string_view pattern, std::string_view name);

/// "'a', 'b' and 3 more", "none with a name" of none. Empty names do not count.
std::string quoted_names(std::set<std::string> names);

}  // namespace elastogen
