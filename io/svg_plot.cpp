// SPDX-License-Identifier: Apache-2.0
#include "io/svg_plot.hpp"

#include "core/error.hpp"
#include "io/svg_drawing.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

constexpr double kLeastHeight = 160, kMostHeight = 480;  // of the frame around outlines [px]

void check_lengths(const LinePlot& plot) {
  for (const PlotSeries& s : plot.series)
    ELASTOGEN_CHECK(s.x.size() == s.y.size() && (s.labels.empty() || s.labels.size() == s.x.size()),
                    "series '", s.name, "' of plot '", plot.title, "' has ", s.x.size(), " x, ",
                    s.y.size(), " y and ", s.labels.size(), " labels");
}

/// Axes around the points that can be drawn on both.
SvgDrawing axes_around(const LinePlot& plot) {
  std::vector<double> x, y;
  for (const PlotSeries& series : plot.series)
    for (size_t k = 0; k < series.x.size(); ++k) {
      if (!can_be_drawn(series.x[k], plot.x.log) || !can_be_drawn(series.y[k], plot.y.log))
        continue;
      x.push_back(series.x[k]);
      y.push_back(series.y[k]);
    }
  return {{}, range_around(x, plot.x.log), range_around(y, plot.y.log), plot.x.label, plot.y.label};
}

/// The points of a line one after the other, as data of an SVG path.
struct Path {
  std::string data;
  bool joined = false;
  int64_t left_out = 0;

  /// @return the place of the point, "" if it cannot be drawn.
  std::string add(const SvgDrawing& drawing, double x, double y) {
    const std::string place = drawing.has_place(x, y) ? drawing.place(x, y) : "";
    if (!place.empty()) data += (joined ? 'L' : 'M') + place;
    joined = !place.empty();
    left_out += !joined;
    return place;
  }
};

/// @return the number of points that cannot be drawn.
int64_t draw(SvgDrawing& drawing, const PlotSeries& series, size_t index) {
  const size_t points = series.x.size(), every = points > 40 ? points / 20 : 1;
  Path path;
  std::string markers;
  for (size_t k = 0; k < points; ++k) {
    const std::string place = path.add(drawing, series.x[k], series.y[k]);
    if (!place.empty() && k % every == 0)
      markers += drawing.marker(place, index, series.labels.empty() ? "" : series.labels[k]);
  }
  drawing.add(index, drawing.line(path.data, index, DashEvery::kColours) + markers);
  return path.left_out;
}

/// @return the number of points that cannot be drawn.
int64_t draw(SvgDrawing& drawing, const Outline& outline, size_t index) {
  Path path;
  std::string markers;
  for (const Polyline& line : outline.lines) {
    path.joined = false;
    for (const auto& [x, y] : line) {
      const std::string place = path.add(drawing, x, y);
      if (!place.empty() && line.size() == 1) markers += drawing.marker(place, index);
    }
  }
  drawing.add(index, drawing.line(path.data, index, DashEvery::kSeries) + markers);
  return path.left_out;
}

/// The extent of the outlines in one direction [m].
struct Extent {
  double low = INFINITY, high = -INFINITY;

  double middle() const { return low + (high - low) / 2; }
};

std::array<Extent, 2> extents_of(const std::vector<Outline>& outlines) {
  std::array<Extent, 2> extents;
  for (const Outline& outline : outlines)
    for (const Polyline& line : outline.lines)
      for (const auto& point : line) {
        if (!can_be_drawn(point[0], false) || !can_be_drawn(point[1], false)) continue;
        for (size_t d = 0; d < 2; ++d) {
          extents[d].low = std::min(extents[d].low, point[d]);
          extents[d].high = std::max(extents[d].high, point[d]);
        }
      }
  if (extents[0].low > extents[0].high) extents = {{{0, 1}, {0, 1}}};
  return extents;
}

/// Axes around the outlines, both with one scale.
SvgDrawing axes_around(const OutlinePlot& plot) {
  const auto [x, y] = extents_of(plot.outlines);
  double width = 1.1 * (x.high - x.low), height = 1.1 * (y.high - y.low);
  // all points at one place: the axes span a fifth of their distance from the origin
  const double away = std::max(std::abs(x.middle()), std::abs(y.middle()));
  if (std::max(width, height) <= 1e-12 * away) width = height = away / 5;
  if (std::max(width, height) <= 1e-290) width = height = 1;

  PlotFrame frame;
  frame.height = std::clamp(frame.width * (height / std::max(width, 1e-3 * height)), kLeastHeight,
                            kMostHeight);
  const double metres_a_px = std::max(width / frame.width, height / frame.height);
  const double half_x = frame.width * metres_a_px / 2, half_y = frame.height * metres_a_px / 2;
  return {frame,
          {false, x.middle() - half_x, x.middle() + half_x},
          {false, y.middle() - half_y, y.middle() + half_y},
          plot.x_label,
          plot.y_label};
}

}  // namespace

SvgPlot line_plot(const LinePlot& plot) {
  check_lengths(plot);
  SvgDrawing drawing = axes_around(plot);
  SvgPlot result;
  std::vector<std::string> names;
  for (const PlotSeries& series : plot.series) {
    result.left_out += draw(drawing, series, names.size());
    names.push_back(series.name);
  }
  drawing.add_legend(names, true, DashEvery::kColours);
  result.svg = drawing.finished(plot.title);
  return result;
}

SvgPlot outline_plot(const OutlinePlot& plot) {
  SvgDrawing drawing = axes_around(plot);
  SvgPlot result;
  std::vector<std::string> names;
  for (const Outline& outline : plot.outlines) {
    result.left_out += draw(drawing, outline, names.size());
    names.push_back(outline.name);
  }
  drawing.add_legend(names, false, DashEvery::kSeries);
  result.svg = drawing.finished(plot.title);
  return result;
}

}  // namespace elastogen
