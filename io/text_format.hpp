// SPDX-License-Identifier: Apache-2.0
// Numbers and foreign text for pages and tables, independent of the locale.

#pragma once

#include <string>
#include <string_view>

namespace elastogen {

/// The text with references in place of & < > " and ', which makes it safe as content or quoted
/// attribute of HTML and SVG. Bytes that are not UTF-8 and control characters other than tab and
/// line feed become U+FFFD.
std::string markup_text(std::string_view text);

/// The number to some significant digits, as "%.*g"; "nan", "inf", "-inf".
std::string short_number(double value, int digits);

/// The number with a fixed count of decimals, as "%.*f".
std::string fixed_number(double value, int decimals);

/// The shortest text that reads back as the same bits; "nan", "inf", "-inf".
std::string exact_number(double value);

}  // namespace elastogen
