// SPDX-License-Identifier: Apache-2.0
// Tables and figures of a page, as HTML that is well-formed XML too.

#pragma once

#include "io/svg_plot.hpp"

namespace elastogen {

/// A head over several columns.
struct HeadGroup {
  std::string text;
  int columns = 1;
};

/// Heads and cells are plain text; the first cell of a row is its head.
struct HtmlTable {
  std::string caption;
  std::vector<HeadGroup> groups;  ///< above the heads; empty, or covering all columns
  std::vector<std::string> heads;
  std::vector<std::vector<std::string>> rows;
};

std::string html_table(const HtmlTable& table);

/// The plot with its caption and, if points are left out of it, a note with their number.
std::string html_figure(const SvgPlot& plot, const std::string& caption);

/// A section with a heading; "" without content.
std::string html_section(const std::string& heading, const std::string& content);

/// A cell: four significant digits, all before the point up to 1e7; "nan" or "inf".
std::string number_cell(double value);

/// A cell for a value that does not exist: a dash.
inline constexpr const char* kNoCell = "\xe2\x80\x93";

}  // namespace elastogen
