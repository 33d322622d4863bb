// SPDX-License-Identifier: Apache-2.0
#include "io/svg_plot.hpp"

#include "io/svg_drawing.hpp"
#include "tests/io/markup_check.hpp"
#include "tests/io/study_example.hpp"
#include "tests/io/test_files.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <regex>
#include <set>
#include <sstream>

namespace elastogen {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kRounding = 0.0051;  // coordinates have two decimals

using Points = std::vector<std::array<double, 2>>;

/// The elements of a series, but for its legend.
std::string elements_of(const std::string& svg, int series) {
  const auto groups = test::parts_between(svg, concat("<g class=\"c", series, '"'), "</g>");
  return groups.empty() ? "" : groups[0];
}

/// Places of its markers [px].
Points markers_of(const std::string& svg, int series = 0) {
  Points points;
  for (const std::string& place :
       test::parts_between(elements_of(svg, series), "\"translate(", ")\"")) {
    std::istringstream numbers(place);
    numbers >> points.emplace_back()[0] >> points.back()[1];
  }
  return points;
}

/// Data of its line.
std::string line_of(const std::string& svg, int series = 0) {
  for (const std::string& line :
       test::parts_between(elements_of(svg, series), "class=\"line\"", "/>"))
    return test::parts_between(line, " d=\"", "\"").at(0);
  return "";
}

LinePlot plot_of(std::vector<double> x, std::vector<double> y, bool log) {
  return {"title", {"x [m]", log}, {"y [-]", log}, {{"series", std::move(x), std::move(y), {}}}};
}

void expect_points(const Points& points, const Points& expected) {
  ASSERT_EQ(points.size(), expected.size());
  for (size_t k = 0; k < points.size(); ++k)
    for (size_t d = 0; d < 2; ++d) EXPECT_NEAR(points[k][d], expected[k][d], kRounding) << k;
}

TEST(LinePlot, PutsPointsWhereTheLogarithmSays) {
  const std::vector<double> x = {2, 10, 250}, y = {0.05, 0.01, 3e-4};
  const SvgPlot plot = line_plot(plot_of(x, y, true));
  // axes 1 ... 1e3 and 1e-4 ... 1e-1 over 460 x 300 px from (84, 30)
  Points expected;
  for (size_t k = 0; k < 3; ++k)
    expected.push_back({84 + 460 * std::log(x[k]) / std::log(1000.0),
                        30 + 300 * (-1 - std::log(y[k]) / std::log(10.0)) / 3});
  expect_points(markers_of(plot.svg), expected);
  EXPECT_EQ(plot.left_out, 0);
  EXPECT_EQ(line_of(plot.svg).substr(0, 2), "M1");  // 84 + 460 log10(2)/3 = 130.2
  EXPECT_EQ(test::count_of(line_of(plot.svg), "L"), 2);
}

TEST(LinePlot, PutsPointsWhereTheLinearMapSays) {
  // a fifth of 11 is above 2: steps of 5, axis -5 ... 10; a fifth of 0.5 is 0.1: axis 0 ... 0.5
  const SvgPlot plot = line_plot(plot_of({-3, 0, 8}, {0, 0.25, 0.5}, false));
  expect_points(
      markers_of(plot.svg),
      {{84 + 460 * 2 / 15.0, 330}, {84 + 460 * 5 / 15.0, 180}, {84 + 460 * 13 / 15.0, 30}});
}

TEST(LinePlot, LeavesOutAndCountsWhatHasNoPlace) {
  const std::vector<double> x = {1, 2, 3, 4, 5, 6, 7, 8};
  const std::vector<double> y = {1, kNaN, 10, 0, -5, kInf, -kInf, 100};
  const SvgPlot log = line_plot(plot_of(x, y, true));
  EXPECT_EQ(log.left_out, 5);
  EXPECT_EQ(markers_of(log.svg).size(), 3u);
  // the line does not run across points that are left out
  EXPECT_EQ(test::count_of(line_of(log.svg), "M"), 3);
  EXPECT_EQ(test::count_of(line_of(log.svg), "L"), 0);

  const SvgPlot linear = line_plot(plot_of(x, y, false));
  EXPECT_EQ(linear.left_out, 3);
  EXPECT_EQ(markers_of(linear.svg).size(), 5u);
  EXPECT_EQ(test::count_of(line_of(linear.svg), "M"), 3);
  // a point counts once, whichever of its coordinates is at fault
  EXPECT_EQ(line_plot(plot_of({0, -1, 1}, {0, 1, 1}, true)).left_out, 2);
}

/// Well-formed, without a number that is none, and all markers within the axes.
void expect_sound(const SvgPlot& plot) {
  EXPECT_EQ(test::markup_fault(plot.svg), "");
  const std::string outside_of_texts = std::regex_replace(plot.svg, std::regex(">[^<]*<"), "><");
  for (const char* bad : {"nan", "inf", "e+", "e-0"})
    EXPECT_EQ(outside_of_texts.find(bad), std::string::npos) << bad;
  for (const auto& [x, y] : markers_of(plot.svg)) {
    EXPECT_TRUE(x >= 84 && x <= 544) << x;
    EXPECT_TRUE(y >= 30 && y <= 510) << y;
  }
}

TEST(LinePlot, IsSoundForAnyNumbers) {
  const double tiny = 5e-324, huge = std::numeric_limits<double>::max();
  // none, one, equal, tiny, huge and close values
  const std::vector<std::vector<double>> values = {{},
                                                   {3},
                                                   {0},
                                                   {kNaN},
                                                   {7, 7, 7},
                                                   {-2, -2},
                                                   {tiny},
                                                   {0, tiny},
                                                   {tiny, 1e300},
                                                   {huge, 1},
                                                   {-1e300, 1e300},
                                                   {1, std::nextafter(1, 2)},
                                                   {1e9, 1e9 + 1e-6},
                                                   {1e-300, 2e-300},
                                                   {1e5, 1e-5}};
  // values that can be drawn are drawn, the others are counted
  for (const std::vector<double>& v : values)
    for (const bool log : {false, true}) {
      const SvgPlot plot = line_plot(plot_of(v, v, log));
      expect_sound(plot);
      size_t drawn = 0;
      for (const double value : v) drawn += can_be_drawn(value, log);
      EXPECT_EQ(markers_of(plot.svg).size(), drawn);
      EXPECT_EQ(plot.left_out, int64_t(v.size() - drawn));
    }
  expect_sound(line_plot({}));
}

TEST(LinePlot, PutsEqualValuesInTheMiddle) {
  // 4 +- 0.4: a fifth of 0.8 is below 0.2, axis 3.6 ... 4.4
  expect_points(markers_of(line_plot(plot_of({4}, {4}, false)).svg), {{314, 180}});
  expect_points(markers_of(line_plot(plot_of({0}, {0}, false)).svg), {{314, 180}});
  expect_points(markers_of(line_plot(plot_of({1e-3}, {100}, true)).svg), {{314, 180}});
}

TEST(LinePlot, EscapesEveryName) {
  LinePlot plot = plot_of({1, 2}, {1, 2}, false);
  plot.title = plot.x.label = plot.y.label = plot.series[0].name = test::kHostile;
  plot.series[0].labels = {test::kHostile, test::kHostile};
  const SvgPlot svg = line_plot(plot);
  expect_sound(svg);
  EXPECT_EQ(svg.svg.find("<script"), std::string::npos);
  EXPECT_EQ(svg.svg.find("<img"), std::string::npos);
  EXPECT_GE(test::count_of(svg.svg, "&lt;script&gt;"), 7);
}

TEST(LinePlot, CutsLongNamesBetweenLetters) {
  LinePlot plot = plot_of({1}, {1}, false);
  std::string name;
  for (int k = 0; k < 60; ++k) name += "\xc3\xb6";
  plot.series[0].name = name;
  const std::string svg = line_plot(plot).svg;
  EXPECT_EQ(svg.find("\xef\xbf\xbd"), std::string::npos);
  test::expect_says(svg, name.substr(0, 68) + "...</text>");
  test::expect_says(svg, "<title>" + name + "</title>");
}

TEST(LinePlot, TellsSeriesApartByColourMarkerAndDash) {
  LinePlot plot{"title", {"x"}, {"y"}, {}};
  for (int k = 0; k < 30; ++k) plot.series.push_back({"s", {0, 1}, {double(k), 1}, {}});
  const std::string svg = line_plot(plot).svg;
  expect_sound({svg, 0});
  static const std::regex group(
      "<g class=\"c[0-9]\" stroke=\"([^\"]*)\">\n<path class=\"line\"[^>]* d=\"[^\"]*\"([^>]*)/>\n"
      "<path class=\"mark\"[^>]* d=\"([^\"]*)\"");
  std::set<std::string> looks;
  for (std::sregex_iterator it(svg.begin(), svg.end(), group), end; it != end; ++it)
    looks.insert((*it)[1].str() + '|' + (*it)[2].str() + '|' + (*it)[3].str());
  EXPECT_EQ(looks.size(), 30u);  // each once in the plot and the same in the legend
  // on a dark screen the shades change, their number does not
  std::set<std::string> shades;
  static const std::regex rule("\\.c[0-9]\\{stroke:(#[0-9a-f]{6})\\}");
  const std::string style = plot_style();
  for (std::sregex_iterator it(style.begin(), style.end(), rule), end; it != end; ++it)
    shades.insert((*it)[1]);
  EXPECT_EQ(shades.size(), 7u);
}

TEST(LinePlot, HasFewMarkersOnLongLines) {
  std::vector<double> x(1000);
  for (size_t k = 0; k < x.size(); ++k) x[k] = double(k);
  const std::string svg = line_plot(plot_of(x, x, false)).svg;
  EXPECT_EQ(markers_of(svg).size(), 20u);
  EXPECT_EQ(test::count_of(line_of(svg), "L"), 999);
}

TEST(LinePlot, RejectsSeriesOfDifferentLengths) {
  const std::string text = test::error_of(
      [] {
        line_plot(plot_of({1, 2}, {1}, false));
      },
      ErrorKind::kUsage);
  test::expect_says(text, "series 'series' of plot 'title' has 2 x, 1 y");
  LinePlot plot = plot_of({1, 2}, {1, 2}, false);
  plot.series[0].labels = {"a"};
  test::error_of([&] { line_plot(plot); }, ErrorKind::kUsage);
}

/// The texts of the ticks, and the shares where the text is not empty.
std::vector<std::pair<double, std::string>> named_ticks(const AxisRange& range) {
  std::vector<std::pair<double, std::string>> named;
  for (const AxisTick& tick : axis_ticks(range))
    if (!tick.text.empty()) named.emplace_back(tick.share, tick.text);
  return named;
}

using Named = std::vector<std::pair<double, std::string>>;

TEST(AxisTicks, StandAtDecades) {
  const AxisRange range = range_around({2e-4, 0.03, 0.9}, true);
  EXPECT_EQ(named_ticks(range),
            (Named{{0, "1e-4"}, {0.25, "1e-3"}, {0.5, "1e-2"}, {0.75, "1e-1"}, {1, "1e0"}}));
  const std::vector<AxisTick> all = axis_ticks(range);
  ASSERT_EQ(all.size(), 37u);
  EXPECT_NEAR(all[1].share, std::log10(2) / 4, 1e-15);

  // ends that are decades stay; more than eight decades get every second name
  EXPECT_EQ(named_ticks(range_around({1e-3, 1e3}, true)).size(), 7u);
  EXPECT_EQ(
      named_ticks(range_around({1e-10, 1}, true)),
      (Named{
          {0, "1e-10"}, {0.2, "1e-8"}, {0.4, "1e-6"}, {0.6, "1e-4"}, {0.8, "1e-2"}, {1, "1e0"}}));
  // within two decades 2 and 5 have names too
  EXPECT_EQ(named_ticks(range_around({0.02, 0.05}, true)).size(), 4u);
  EXPECT_EQ(named_ticks(range_around({0.02, 0.05}, true))[1].second, "0.02");
}

TEST(AxisTicks, AreRoundNumbers) {
  EXPECT_EQ(
      named_ticks(range_around({0.02, 0.49}, false)),
      (Named{
          {0, "0"}, {0.2, "0.1"}, {0.4, "0.2"}, {3 * 0.1 / 0.5, "0.3"}, {0.8, "0.4"}, {1, "0.5"}}));
  EXPECT_EQ(named_ticks(range_around({-1200, 12000}, false)).front().second, "-5000");
  // as many digits as tell neighbours apart
  std::set<std::string> texts;
  for (const auto& [share, text] : named_ticks(range_around({1e6, 1e6 + 1e-3}, false))) {
    EXPECT_TRUE(texts.insert(text).second) << text;
    EXPECT_NEAR(std::stod(text), 1e6 + 1e-3 * share, 1e-8);
  }
  EXPECT_GE(texts.size(), 3u);
}

TEST(OutlinePlot, HasOneScaleForBothAxes) {
  const OutlinePlot plot{
      "shape",
      "x [m]",
      "y [m]",
      {{"square", {{{0, 0}}, {{0.25, 0}}, {{0.25, 0.25}}, {{-1, 0.5}}, {{2, 0.75}}}}}};
  const Points p = markers_of(outline_plot(plot).svg);
  ASSERT_EQ(p.size(), 5u);
  EXPECT_NEAR(p[1][0] - p[0][0], p[1][1] - p[2][1], 2 * kRounding);
  // 3 m and a tenth more are 460 px wide
  EXPECT_NEAR(p[4][0] - p[3][0], 460 / 1.1, 2 * kRounding);
  EXPECT_GT(p[1][0], p[0][0]);
  EXPECT_LT(p[2][1], p[1][1]);  // up is up
}

TEST(OutlinePlot, DrawsLinesSegmentsAndPoints) {
  const OutlinePlot plot{"shape",
                         "x [m]",
                         "y [m]",
                         {{"a", {{{0, 0}, {1, 0}, {1, 1}}, {{0, 1}, {0.5, 1}}, {{0.5, 0.5}}, {}}},
                          {"b", {{{0, 0}, {kNaN, 0}, {1, 1}, {1, 0}}}}}};
  const SvgPlot svg = outline_plot(plot);
  expect_sound(svg);
  EXPECT_EQ(svg.left_out, 1);
  EXPECT_EQ(test::count_of(line_of(svg.svg), "M"), 3);
  EXPECT_EQ(test::count_of(line_of(svg.svg), "L"), 3);
  EXPECT_EQ(markers_of(svg.svg).size(), 1u);
  EXPECT_EQ(test::count_of(line_of(svg.svg, 1), "M"), 2);
  EXPECT_EQ(test::count_of(line_of(svg.svg, 1), "L"), 1);
  // in print a dash tells them apart
  EXPECT_EQ(test::count_of(elements_of(svg.svg, 0), "dasharray"), 0);
  EXPECT_EQ(test::count_of(elements_of(svg.svg, 1), "dasharray"), 1);
}

TEST(OutlinePlot, IsSoundForAnyShape) {
  const std::vector<Polyline> lines = {{},
                                       {{0, 0}},
                                       {{3, -4}},
                                       {{1e300, -1e300}},
                                       {{0, 0}, {1, 0}},
                                       {{0, 0}, {0, 1}},
                                       {{0, 0}, {5e-324, 0}},
                                       {{0, 0}, {1e-6, 1e6}},
                                       {{kInf, 0}, {kNaN, kNaN}},
                                       {{1e9, 1}, {1e9, 1}},
                                       {{-1e300, 0}, {1e300, 1}}};
  for (const Polyline& line : lines) {
    const SvgPlot plot = outline_plot({test::kHostile, "x", "y", {{test::kHostile, {line}}}});
    expect_sound(plot);
  }
  expect_sound(outline_plot({}));
}

}  // namespace
}  // namespace elastogen
