// SPDX-License-Identifier: Apache-2.0
#include "io/html_table.hpp"

#include "core/error.hpp"
#include "io/text_format.hpp"

#include <cmath>

namespace elastogen {
namespace {

std::string head_rows(const HtmlTable& table) {
  std::string rows;
  if (!table.groups.empty()) {
    rows += "<tr>";
    for (const HeadGroup& group : table.groups)
      rows += concat("<th class=\"group\" colspan=\"", group.columns, "\">",
                     markup_text(group.text), "</th>");
    rows += "</tr>\n";
  }
  rows += "<tr>";
  for (const std::string& head : table.heads)
    rows += concat("<th scope=\"col\">", markup_text(head), "</th>");
  return rows + "</tr>\n";
}

}  // namespace

std::string html_table(const HtmlTable& table) {
  std::string html = "<div class=\"table\"><table>\n";
  if (!table.caption.empty())
    html += concat("<caption>", markup_text(table.caption), "</caption>\n");
  html += concat("<thead>\n", head_rows(table), "</thead>\n<tbody>\n");
  for (const std::vector<std::string>& row : table.rows) {
    html += "<tr>";
    for (size_t k = 0; k < row.size(); ++k)
      html += concat(k == 0 ? "<th scope=\"row\">" : "<td>", markup_text(row[k]),
                     k == 0 ? "</th>" : "</td>");
    html += "</tr>\n";
  }
  return html + "</tbody>\n</table></div>\n";
}

std::string html_figure(const SvgPlot& plot, const std::string& caption) {
  std::string note;
  if (plot.left_out > 0)
    note = concat(" <strong>Left out: ", plot.left_out, plot.left_out == 1 ? " point" : " points",
                  " without a place on these axes (zero, negative or not finite).</strong>");
  return concat("<figure>\n", plot.svg, "<figcaption>", markup_text(caption), note,
                "</figcaption>\n</figure>\n");
}

std::string html_section(const std::string& heading, const std::string& content) {
  if (content.empty()) return "";
  return concat("<section>\n<h2>", markup_text(heading), "</h2>\n", content, "</section>\n");
}

std::string number_cell(double value) {
  const bool large = std::abs(value) >= 1e4 && std::abs(value) < 1e7;
  return large ? fixed_number(value, 0) : short_number(value, 4);
}

}  // namespace elastogen
