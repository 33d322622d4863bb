// SPDX-License-Identifier: Apache-2.0
#include "io/html_page.hpp"

#include "core/error.hpp"
#include "io/svg_plot.hpp"
#include "io/text_format.hpp"

namespace elastogen {
namespace {

constexpr const char* kPageStyle = R"(:root{color-scheme:light dark}
body{font:15px/1.45 sans-serif;margin:2em auto;padding:0 1em;max-width:1200px;
color:#1b1b1b;background:#ffffff}
h1{font-size:1.6em}
h2{font-size:1.2em;margin-top:2em}
.table{overflow-x:auto}
table{border-collapse:collapse;font-size:13px;margin:1em 0}
caption{text-align:left;padding:.3em 0;font-weight:bold}
th,td{border:1px solid #c4c4c4;padding:.25em .5em;text-align:right;vertical-align:top;
overflow-wrap:break-word}
thead th{text-align:center;vertical-align:bottom}
tbody th{text-align:left;font-weight:normal;overflow-wrap:anywhere}
figure{margin:1em 0}
figcaption{font-size:13px;max-width:60em}
pre{overflow-x:auto;white-space:pre-wrap;overflow-wrap:anywhere;font-size:12px}
@media screen and (prefers-color-scheme:dark){
body{color:#e8e8e8;background:#181818}
th,td{border-color:#4a4a4a}
}
@media print{
@page{size:A4 landscape;margin:12mm}
body{margin:0;max-width:none;font-size:10pt;color:#000000;background:#ffffff}
table{font-size:6.5pt}
th,td{padding:.15em .3em}
.table{overflow-x:visible}
.plot{width:auto;max-height:76mm}
figure,tr{break-inside:avoid}
h2,caption{break-after:avoid}
}
)";

}  // namespace

std::string html_page(const std::string& title, const std::string& body) {
  return concat(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n<title>",
      markup_text(title), "</title>\n<style>\n", kPageStyle, plot_style(),
      "</style>\n</head>\n<body>\n", body, "</body>\n</html>\n");
}

}  // namespace elastogen
