// SPDX-License-Identifier: Apache-2.0
// Cells of text files that people write for fits: between separators, without blanks around.

#pragma once

#include "core/error.hpp"

#include <charconv>
#include <sstream>
#include <string>
#include <vector>

namespace elastogen {

inline std::string trimmed(const std::string& text) {
  const size_t begin = text.find_first_not_of(" \t\r");
  if (begin == std::string::npos) return "";
  return text.substr(begin, text.find_last_not_of(" \t\r") + 1 - begin);
}

inline std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, separator);) parts.push_back(trimmed(part));
  return parts;
}

/// The number that the whole text spells; "nan" and "inf" count. @throws Error quoting other texts.
inline double number(const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  ELASTOGEN_CHECK(error == std::errc() && end == text.data() + text.size(), "'", text,
                  "' is not a number");
  return value;
}

}  // namespace elastogen
