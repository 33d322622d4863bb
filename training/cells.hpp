// SPDX-License-Identifier: Apache-2.0
// Cells of the text files that people write for fits: between separators, blanks around them off.

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

/// A number that is all of the text; "nan" and "inf" are. @throws Error quoting what is none.
inline double number(const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  ELASTOGEN_CHECK(error == std::errc() && end == text.data() + text.size(), "'", text,
                  "' is not a number");
  return value;
}

}  // namespace elastogen
