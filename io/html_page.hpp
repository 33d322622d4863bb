// SPDX-License-Identifier: Apache-2.0
// A page of tables and plots: one HTML file with its style in it. It has no scripts and loads
// nothing, and suits light and dark screens and paper.

#pragma once

#include <string>

namespace elastogen {

/// @param title  plain text. @param body  content of <body>, well-formed as XML; so is the page.
std::string html_page(const std::string& title, const std::string& body);

}  // namespace elastogen
