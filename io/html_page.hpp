// SPDX-License-Identifier: Apache-2.0
// A page of tables and plots: one HTML file with its style in it, no scripts and nothing from
// elsewhere, for light and dark screens and for paper.

#pragma once

#include <string>

namespace elastogen {

/// @param title  plain text. @param body  what stands in <body>, well-formed as XML; the page is so
/// too.
std::string html_page(const std::string& title, const std::string& body);

}  // namespace elastogen
