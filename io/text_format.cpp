// SPDX-License-Identifier: Apache-2.0
#include "io/text_format.hpp"

#include "io/json_text.hpp"

#include <nlohmann/json.hpp>

#include <charconv>
#include <cmath>

namespace elastogen {
namespace {

constexpr const char* kReplacement = "\xef\xbf\xbd";  // U+FFFD

/// The text with U+FFFD in place of bytes that are not UTF-8.
std::string valid_utf8(std::string_view text) {
  using Json = nlohmann::json;
  return parsed_sorted_json(Json(text).dump(-1, ' ', false, Json::error_handler_t::replace));
}

template <class... Format>
std::string converted(double value, Format... format) {
  if (std::isnan(value)) return "nan";
  char text[400];  // 309 digits before the point
  const std::to_chars_result end = std::to_chars(text, text + sizeof(text), value, format...);
  return {text, end.ptr};
}

}  // namespace

std::string markup_text(std::string_view text) {
  std::string markup;
  for (const char c : valid_utf8(text)) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '&')
      markup += "&amp;";
    else if (c == '<')
      markup += "&lt;";
    else if (c == '>')
      markup += "&gt;";
    else if (c == '"')
      markup += "&quot;";
    else if (c == '\'')
      markup += "&#39;";
    else if ((byte < 0x20 && c != '\t' && c != '\n') || byte == 0x7f)
      markup += kReplacement;
    else
      markup += c;
  }
  return markup;
}

std::string short_number(double value, int digits) {
  return converted(value, std::chars_format::general, digits);
}

std::string fixed_number(double value, int decimals) {
  return converted(value, std::chars_format::fixed, decimals);
}

std::string exact_number(double value) {
  return converted(value);
}

}  // namespace elastogen
