// SPDX-License-Identifier: Apache-2.0
#include "scene/name_pattern.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace elastogen {
namespace {

constexpr size_t kMostNames = 40;  // names in one sentence

std::string plain(std::string_view name) {
  if (name.starts_with('_')) name.remove_prefix(1);
  std::string result(name);
  for (char& c : result)
    if (c >= 'A' && c <= 'Z') c = char(c - 'A' + 'a');
  return result;
}

}  // namespace

bool matches(std::string_view pattern, std::string_view name) {
  size_t p = 0, n = 0, star = pattern.npos, tried = 0;
  while (n < name.size())
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      tried = n;
    } else if (p < pattern.size() && pattern[p] == name[n]) {
      ++p, ++n;
    } else if (star != pattern.npos) {
      p = star + 1;
      n = ++tried;
    } else {
      return false;
    }
  return pattern.find_first_not_of('*', p) == pattern.npos;
}

bool matches_attribute(std::string_view pattern, std::string_view name) {
  return matches(plain(pattern), plain(name));
}

std::string quoted_names(std::set<std::string> names) {
  names.erase("");
  std::string list;
  size_t count = 0;
  for (const std::string& name : names)
    if (++count <= kMostNames) list += fmt::format("{}'{}'", list.empty() ? "" : ", ", name);
  if (names.size() > kMostNames) list += fmt::format(" and {} more", names.size() - kMostNames);
  return list.empty() ? "none with a name" : list;
}

}  // namespace elastogen
