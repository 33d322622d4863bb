// SPDX-License-Identifier: Apache-2.0
// Reads the files of training/material_test.hpp.

#include "io/units.hpp"
#include "training/cells.hpp"
#include "training/material_test.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

constexpr size_t kMostPoints = 20'000;  // fits of this many need twelve seconds
constexpr double kLeastStretch = 0.02, kMostStretch = 50;

/// A column by its head line.
struct Column {
  std::string name;   ///< mode, stretch, strain or stress
  double factor = 1;  ///< Pa in one unit of stress
};

/// Reads a column from "stress [kPa]".
Column column_of(const std::string& head) {
  const size_t open = head.find('[');
  Column column{trimmed(head.substr(0, open))};
  ELASTOGEN_CHECK(column.name == "mode" || column.name == "stretch" || column.name == "strain" ||
                      column.name == "stress",
                  "unknown column '", head,
                  "'; known are mode, stretch or strain, stress, 'stress [kPa]'");
  if (open == head.npos) return column;
  ELASTOGEN_CHECK(column.name == "stress" && head.back() == ']', "'", head,
                  "': a unit in brackets belongs to stress");
  column.factor = parse_pressure("1 " + head.substr(open + 1, head.size() - open - 2));
  return column;
}

/// Reads and checks the columns of a head line.
std::vector<Column> columns_of(const std::string& line, const std::string& place) {
  std::vector<Column> columns;
  const std::vector<std::string> heads = split(line, ',');
  for (size_t k = 0; k < heads.size(); ++k) {
    try {
      columns.push_back(column_of(heads[k]));
    } catch (const Error& error) {
      throw Error(concat(place, ", column ", k + 1, ": ", error.what()), ErrorKind::kAsset);
    }
  }
  const auto count = [&](const char* name) {
    return std::count_if(columns.begin(), columns.end(),
                         [&](const Column& c) { return c.name == name; });
  };
  ELASTOGEN_CHECK_ASSET(
      count("stretch") + count("strain") == 1 && count("stress") == 1 && count("mode") <= 1, place,
      ": the head line must name one column stretch or strain and one column stress, and mode at "
      "most once; it is '",
      line, "'");
  return columns;
}

LoadPath path_of(const std::string& cell) {
  for (const LoadPath path : {LoadPath::kUniaxial, LoadPath::kBiaxial, LoadPath::kShear})
    if (cell == path_name(path)) return path;
  throw Error(concat("unknown mode '", cell, "'; known are uniaxial, biaxial and shear"));
}

void take(const Column& column, const std::string& cell, TestPoint& point) {
  if (column.name == "mode") return void(point.path = path_of(cell));
  const double value = number(cell);
  ELASTOGEN_CHECK(std::isfinite(value), "'", cell, "' is not finite");
  if (column.name == "stress") return void(point.stress = column.factor * value);
  point.stretch = column.name == "strain" ? 1 + value : value;
  ELASTOGEN_CHECK(point.stretch >= kLeastStretch && point.stretch <= kMostStretch,
                  "a stretch lies between ", kLeastStretch, " and ", kMostStretch,
                  ", a strain is one less and no percentage; got ", cell);
}

TestPoint point_of(const std::vector<Column>& columns, const std::string& line,
                   const std::string& place) {
  const std::vector<std::string> cells = split(line, ',');
  ELASTOGEN_CHECK_ASSET(cells.size() == columns.size(), place, ": expected ", columns.size(),
                        " columns, got ", cells.size());
  TestPoint point;
  for (size_t k = 0; k < cells.size(); ++k) {
    try {
      take(columns[k], cells[k], point);
    } catch (const Error& error) {
      throw Error(concat(place, ", column ", k + 1, " (", columns[k].name, "): ", error.what()),
                  ErrorKind::kAsset);
    }
  }
  return point;
}

}  // namespace

std::vector<TestPoint> read_material_test(const std::string& text, const std::string& source) {
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  std::istringstream stream(text.starts_with(kByteOrderMark) ? text.substr(3) : text);
  std::vector<Column> columns;
  std::vector<TestPoint> points;
  int number = 0;
  // the first line is the head, every further one a point; comments are cut off
  for (std::string line; std::getline(stream, line);) {
    const std::string place = concat(source, ", line ", ++number);
    line = trimmed(line.substr(0, line.find('#')));
    if (line.empty()) continue;
    if (columns.empty()) {
      columns = columns_of(line, place);
      continue;
    }
    ELASTOGEN_CHECK_ASSET(points.size() < kMostPoints, place, ": more than ", kMostPoints,
                          " points; leave some out");
    points.push_back(point_of(columns, line, place));
    points.back().line = number;
  }
  // enough points that say something about a law
  const auto strained = std::count_if(points.begin(), points.end(),
                                      [](const TestPoint& p) { return p.stretch != 1; });
  const bool loaded = std::any_of(points.begin(), points.end(), [](const TestPoint& p) {
    return p.stretch != 1 && p.stress != 0;
  });
  ELASTOGEN_CHECK_ASSET(strained >= 2 && loaded, source, ": needs a head line and at least two ",
                        "points with a stretch other than 1, and stresses other than 0; has ",
                        strained, " such points");
  return points;
}

}  // namespace elastogen
