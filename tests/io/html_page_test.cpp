// SPDX-License-Identifier: Apache-2.0
#include "io/html_page.hpp"

#include "tests/io/markup_check.hpp"

#include <gtest/gtest.h>

namespace elastogen {
namespace {

TEST(HtmlPage, HasTitleStyleAndBodyAndIsWellFormed) {
  const std::string page = html_page("a < b & \"c\"", "<p>body</p>\n");
  EXPECT_EQ(test::markup_fault(page), "");
  EXPECT_EQ(test::parts_between(page, "<title>", "</title>"),
            std::vector<std::string>{"a &lt; b &amp; &quot;c&quot;"});
  EXPECT_EQ(test::parts_between(page, "<body>", "</body>"),
            std::vector<std::string>{"\n<p>body</p>\n"});
  EXPECT_EQ(test::count_of(page, "<style>"), 1);
  // shades of plots and of tables are in it
  EXPECT_NE(page.find(".plot .frame"), std::string::npos);
  EXPECT_NE(page.find("prefers-color-scheme:dark"), std::string::npos);
}

}  // namespace
}  // namespace elastogen
