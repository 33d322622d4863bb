// SPDX-License-Identifier: Apache-2.0
#include "io/svg_drawing.hpp"

#include "core/error.hpp"
#include "io/svg_plot.hpp"
#include "io/text_format.hpp"

#include <algorithm>

namespace elastogen {
namespace {

constexpr size_t kColours = 7;
constexpr const char* kLight[kColours] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                          "#000000", "#56b4e9", "#e69f00"};
constexpr const char* kDark[kColours] = {"#4a9fe0", "#f0752a", "#1fbf92", "#e39fc8",
                                         "#ffffff", "#9ad4f5", "#f2b233"};
// circle, square, triangle, diamond, triangle down, plus, cross, hexagon
constexpr const char* kMarkers[] = {"M-3.5 0a3.5 3.5 0 1 0 7 0a3.5 3.5 0 1 0 -7 0z",
                                    "M-3.2 -3.2h6.4v6.4h-6.4z",
                                    "M0 -4.2L4 3H-4z",
                                    "M0 -4.4L4.4 0L0 4.4L-4.4 0z",
                                    "M0 4.2L4 -3H-4z",
                                    "M-4 0H4M0 -4V4",
                                    "M-3.2 -3.2L3.2 3.2M-3.2 3.2L3.2 -3.2",
                                    "M-4 0L-2 -3.5H2L4 0L2 3.5H-2z"};
constexpr const char* kDashes[] = {"", "7 3", "2 3", "9 3 2 3"};

constexpr double kLegendGap = 16, kLegendWidth = 270, kLegendLine = 18, kBelowAxes = 52;
constexpr size_t kLegendLetters = 34;

std::string pair(double x, double y) {
  return concat(fixed_number(x, 2), ' ', fixed_number(y, 2));
}

/// The first letters of a name that is too long.
std::string shortened(const std::string& name) {
  size_t letters = 0;
  for (size_t k = 0; k < name.size(); ++k) {
    const bool begins_letter = (static_cast<unsigned char>(name[k]) & 0xc0) != 0x80;
    letters += begins_letter;
    if (begins_letter && letters > kLegendLetters) return name.substr(0, k) + "...";
  }
  return name;
}

std::string text_at(double x, double y, const char* anchor, const std::string& text) {
  return concat("<text x=\"", fixed_number(x, 2), "\" y=\"", fixed_number(y, 2),
                "\" text-anchor=\"", anchor, "\">", markup_text(text), "</text>\n");
}

std::string grid_line(const AxisTick& tick, const std::string& path) {
  return concat("<path class=\"",
                tick.text.empty() ? "fine\" stroke=\"#e8e8e8" : "grid\" stroke=\"#c4c4c4",
                "\" d=\"", path, "\"/>\n");
}

std::string in_colour(size_t series, const std::string& elements) {
  const size_t colour = series % kColours;
  return concat("<g class=\"c", colour, "\" stroke=\"", kLight[colour], "\">\n", elements,
                "</g>\n");
}

}  // namespace

SvgDrawing::SvgDrawing(const PlotFrame& frame, const AxisRange& x, const AxisRange& y,
                       const std::string& x_label, const std::string& y_label)
    : frame_(frame), x_(x), y_(y) {
  add_ticks();
  const PlotFrame& f = frame_;
  body_ += concat("<path class=\"frame\" fill=\"none\" stroke=\"#5a5a5a\" d=\"M",
                  pair(f.left, f.top), "h", f.width, "v", f.height, "h", -f.width, "z\"/>\n");
  body_ += text_at(f.left + f.width / 2, f.top + f.height + 38, "middle", x_label);
  body_ += concat("<g transform=\"translate(", pair(16, f.top + f.height / 2), ") rotate(-90)\">\n",
                  text_at(0, 0, "middle", y_label), "</g>\n");
}

void SvgDrawing::add_ticks() {
  const double bottom = frame_.top + frame_.height;
  for (const AxisTick& tick : axis_ticks(x_)) {
    const double x = frame_.left + tick.share * frame_.width;
    body_ += grid_line(tick, concat('M', pair(x, bottom), 'v', -frame_.height));
    if (!tick.text.empty()) body_ += text_at(x, bottom + 17, "middle", tick.text);
  }
  for (const AxisTick& tick : axis_ticks(y_)) {
    const double y = frame_.top + (1 - tick.share) * frame_.height;
    body_ += grid_line(tick, concat('M', pair(frame_.left, y), 'h', frame_.width));
    if (!tick.text.empty()) body_ += text_at(frame_.left - 7, y + 4, "end", tick.text);
  }
}

std::string SvgDrawing::place(double x, double y) const {
  return pair(frame_.left + x_.share(x) * frame_.width,
              frame_.top + (1 - y_.share(y)) * frame_.height);
}

std::string SvgDrawing::marker(const std::string& place, size_t series,
                               const std::string& label) const {
  const std::string title = label.empty() ? "" : "<title>" + markup_text(label) + "</title>";
  return concat("<path class=\"mark\" fill=\"#ffffff\" stroke-width=\"1.5\" transform=\"translate(",
                place, ")\" d=\"", kMarkers[series % std::size(kMarkers)], "\">", title,
                "</path>\n");
}

std::string SvgDrawing::line(const std::string& path, size_t series, DashEvery dash) const {
  if (path.empty()) return "";
  const size_t turn = dash == DashEvery::kSeries ? series : series / kColours;
  const std::string pattern = kDashes[turn % std::size(kDashes)];
  return concat("<path class=\"line\" fill=\"none\" stroke-width=\"1.6\" d=\"", path, '"',
                pattern.empty() ? "" : " stroke-dasharray=\"" + pattern + '"', "/>\n");
}

void SvgDrawing::add(size_t series, const std::string& elements) {
  body_ += in_colour(series, elements);
}

void SvgDrawing::add_legend(const std::vector<std::string>& names, bool markers, DashEvery dash) {
  const double left = frame_.left + frame_.width + kLegendGap;
  for (size_t k = 0; k < names.size(); ++k) {
    const double y = frame_.top + 8 + double(k) * kLegendLine;
    add(k, line(concat('M', pair(left, y), "h30"), k, dash) +
               (markers ? marker(pair(left + 15, y), k) : ""));
    body_ += concat("<g><title>", markup_text(names[k]), "</title>\n",
                    text_at(left + 38, y + 4, "start", shortened(names[k])), "</g>\n");
    legend_bottom_ = y + kLegendLine;
  }
}

std::string SvgDrawing::finished(const std::string& title) const {
  const double width = frame_.left + frame_.width + kLegendGap + kLegendWidth;
  const double height = std::max(frame_.top + frame_.height + kBelowAxes, legend_bottom_);
  return concat(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"plot\" role=\"img\" "
      "font-family=\"sans-serif\" font-size=\"12\" fill=\"#1b1b1b\" width=\"",
      width, "\" height=\"", height, "\" viewBox=\"0 0 ", width, ' ', height, "\">\n", "<title>",
      markup_text(title), "</title>\n", text_at(frame_.left, frame_.top - 12, "start", title),
      body_, "</svg>\n");
}

std::string plot_style() {
  std::string rules =
      ".plot{max-width:100%;height:auto}\n@media screen and (prefers-color-scheme:dark){\n"
      ".plot{fill:#e8e8e8}\n.plot .mark{fill:#181818}\n.plot .grid{stroke:#4a4a4a}\n"
      ".plot .fine{stroke:#2e2e2e}\n.plot .frame{stroke:#a8a8a8}\n";
  for (size_t k = 0; k < kColours; ++k) rules += concat(".plot .c", k, "{stroke:", kDark[k], "}\n");
  return rules + "}\n";
}

}  // namespace elastogen
