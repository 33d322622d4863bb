// SPDX-License-Identifier: Apache-2.0
// Plots as SVG elements of a page: lines with markers over linear or logarithmic axes, and outlines
// of bodies in a plane. Colours follow Okabe and Ito (distinct to the colour-blind), with shades
// for light and dark pages. The marker changes with the colour, the dash changes every seven
// series.

#pragma once

#include "io/outline.hpp"

#include <cstdint>

namespace elastogen {

struct PlotAxis {
  std::string label;  ///< with its unit: "h [m]"
  bool log = false;
};

/// A line with markers at its points; of more than forty points only about twenty have one.
struct PlotSeries {
  std::string name;
  std::vector<double> x, y;         ///< as many
  std::vector<std::string> labels;  ///< of the points, shown under the mouse; none, or as many
};

struct LinePlot {
  std::string title;
  PlotAxis x, y;
  std::vector<PlotSeries> series;
};

struct OutlinePlot {
  std::string title;
  std::string x_label, y_label;  ///< with unit
  std::vector<Outline> outlines;
};

struct SvgPlot {
  std::string svg;       ///< one element, well-formed as XML
  int64_t left_out = 0;  ///< points that cannot be drawn: not finite, or <= 0 on log axes
};

/// The axes end at ticks (range_around) and lie as PlotFrame says. A line has a gap where a point
/// is left out.
/// @throws Error naming the series whose x, y and labels have different lengths.
SvgPlot line_plot(const LinePlot& plot);

/// Outlines with one scale for both axes; a line with one point is drawn as a marker.
SvgPlot outline_plot(const OutlinePlot& plot);

/// Styles of plots for a page's <style>: shades for dark screens, width for narrow screens. Without
/// it plots look as on paper.
std::string plot_style();

}  // namespace elastogen
