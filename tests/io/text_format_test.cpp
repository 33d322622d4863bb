// SPDX-License-Identifier: Apache-2.0
#include "io/text_format.hpp"

#include "tests/io/markup_check.hpp"
#include "tests/io/study_example.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <limits>

namespace elastogen {
namespace {

TEST(MarkupText, ReplacesWhatMarkupWouldRead) {
  EXPECT_EQ(markup_text("a < b && c > \"d\" 'e'\n\t"),
            "a &lt; b &amp;&amp; c &gt; &quot;d&quot; &#39;e&#39;\n\t");
  EXPECT_EQ(markup_text("gr\xc3\xb6\xc3\x9f\x65 \xe2\x82\xac"),
            "gr\xc3\xb6\xc3\x9f\x65 \xe2\x82\xac");
  EXPECT_EQ(markup_text(""), "");
}

TEST(MarkupText, ReplacesWhatIsNoText) {
  const std::string replacement = "\xef\xbf\xbd";
  EXPECT_EQ(markup_text(std::string("a\0b\x1b\x7f\r", 6)),
            "a" + replacement + "b" + replacement + replacement + replacement);
  EXPECT_EQ(markup_text("\xff"), replacement);
  // a letter that ends too early, and one in more bytes than it needs
  EXPECT_EQ(markup_text("\xc3"), replacement);
  EXPECT_EQ(markup_text("\xc0\xbc").find('<'), std::string::npos);
  EXPECT_EQ(test::markup_fault("<p title=\"" + markup_text(test::kHostile) + "\">" +
                               markup_text(test::kHostile) + "</p>"),
            "");
}

TEST(MarkupCheck, FindsFaults) {
  EXPECT_EQ(test::markup_fault("<!DOCTYPE html>\n<a b=\"c\"><d/>e &amp; f</a>\n"), "");
  for (const char* bad : {"<a>", "</a>", "<a></b>", "<a><b></a></b>", "a & b", "a > b", "<a b=c/>",
                          "<a b=\"c", "<a b=\"&\"/>", "<a <b/>", "< a/>", "a \x01 b"})
    EXPECT_NE(test::markup_fault(bad), "") << bad;
}

TEST(Numbers, ReadBackAsTheSameBits) {
  for (const double value : {0.1, 1.0 / 3, -0.0, 5e-324, 1.7976931348623157e308, 6.02e23, 1e22}) {
    const double back = std::strtod(exact_number(value).c_str(), nullptr);
    EXPECT_EQ(std::memcmp(&back, &value, sizeof(value)), 0) << exact_number(value);
  }
  EXPECT_EQ(exact_number(-std::numeric_limits<double>::quiet_NaN()), "nan");
  EXPECT_EQ(exact_number(-std::numeric_limits<double>::infinity()), "-inf");
}

TEST(Numbers, HaveTheAskedDigits) {
  EXPECT_EQ(short_number(0.000123456, 4), "0.0001235");
  EXPECT_EQ(short_number(12345.6, 3), "1.23e+04");
  EXPECT_EQ(short_number(std::numeric_limits<double>::infinity(), 4), "inf");
  EXPECT_EQ(fixed_number(2.005, 1), "2.0");
  EXPECT_EQ(fixed_number(-1e300, 0).size(), 302u);
}

}  // namespace
}  // namespace elastogen
