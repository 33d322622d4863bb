// SPDX-License-Identifier: Apache-2.0
// The parts of a plot as SVG text: axes, lines, markers, legend (io/svg_plot.hpp puts them
// together).

#pragma once

#include "io/svg_axis.hpp"

#include <string>
#include <vector>

namespace elastogen {

/// Place of the axes in a plot [px]: shares (s, t) lie at (left + s width, top + (1 - t) height).
struct PlotFrame {
  double left = 84, top = 30, width = 460, height = 300;
};

/// How many series have one dash before the next dash is used.
enum class DashEvery { kColours, kSeries };

/// A plot while it is drawn. Series are counted from 0; each has its colour, marker and dash.
class SvgDrawing {
 public:
  /// Begins with the axes, their ticks and labels.
  SvgDrawing(const PlotFrame& frame, const AxisRange& x, const AxisRange& y,
             const std::string& x_label, const std::string& y_label);

  bool has_place(double x, double y) const {
    return can_be_drawn(x, x_.log) && can_be_drawn(y, y_.log);
  }
  /// "12.34 56.78", the place of a point that can be drawn [px].
  std::string place(double x, double y) const;

  /// The marker of a series; the label is shown under the mouse.
  std::string marker(const std::string& place, size_t series, const std::string& label = "") const;
  /// A line along the data of an SVG path; "" if there are none.
  std::string line(const std::string& path, size_t series, DashEvery dash) const;

  /// Adds elements in the colour of a series.
  void add(size_t series, const std::string& elements);
  /// Adds the names of the series in order, to the right of the axes; long ones are cut.
  void add_legend(const std::vector<std::string>& names, bool markers, DashEvery dash);

  /// The plot as one <svg> element.
  std::string finished(const std::string& title) const;

 private:
  void add_ticks();

  PlotFrame frame_;
  AxisRange x_, y_;
  std::string body_;
  double legend_bottom_ = 0;
};

}  // namespace elastogen
