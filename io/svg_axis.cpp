// SPDX-License-Identifier: Apache-2.0
#include "io/svg_axis.hpp"

#include "core/error.hpp"
#include "io/text_format.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

/// The least of 1, 2, 5, 10 times a power of ten that is at least a fifth of the span.
double tick_step(double span) {
  const double power = std::pow(10, std::floor(std::log10(span / 5)));
  for (const double factor : {1, 2, 5})
    if (factor * power >= span / 5) return factor * power;
  return 10 * power;
}

AxisRange decades_around(double least, double most) {
  AxisRange range{true, std::floor(std::log10(least)), std::ceil(std::log10(most))};
  if (range.low == range.high) {
    range.low -= 1;
    range.high += 1;
  }
  return range;
}

std::string decade_text(const AxisRange& range, int digit, int exponent) {
  const bool plain = range.low >= -3 && range.high <= 4;
  return plain ? short_number(digit * std::pow(10, exponent), 6) : concat(digit, 'e', exponent);
}

std::vector<AxisTick> decade_ticks(const AxisRange& range) {
  const int decades = int(range.high - range.low), every = (decades + 7) / 8;
  std::vector<AxisTick> ticks;
  for (int k = 0; k <= decades; ++k) {
    const int exponent = int(range.low) + k;
    if (k % every == 0) ticks.push_back({k / double(decades), decade_text(range, 1, exponent)});
    if (decades > 4 || k == decades) continue;
    for (int digit = 2; digit <= 9; ++digit) {
      const bool named = decades <= 2 && (digit == 2 || digit == 5);
      ticks.push_back(
          {(k + std::log10(digit)) / decades, named ? decade_text(range, digit, exponent) : ""});
    }
  }
  return ticks;
}

}  // namespace

double AxisRange::share(double value) const {
  return ((log ? std::log10(value) : value) - low) / (high - low);
}

bool can_be_drawn(double value, bool log) {
  return std::abs(value) <= 1e300 && (!log || value > 0);
}

AxisRange range_around(const std::vector<double>& values, bool log) {
  if (values.empty()) return {log, 0, 1};
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  if (log) return decades_around(*least, *most);
  const double largest = std::max(std::abs(*least), std::abs(*most));
  double low = *least, high = *most;
  // values that differ by rounding only are equal
  if (high - low <= std::max(1e-12 * largest, 1e-290)) {
    const double margin = largest > 1e-290 ? largest / 10 : 1;
    low -= margin;
    high += margin;
  }
  const double step = tick_step(high - low);
  return {false, std::floor(low / step) * step, std::ceil(high / step) * step};
}

std::vector<AxisTick> axis_ticks(const AxisRange& range) {
  if (range.log) return decade_ticks(range);
  const double span = range.high - range.low, step = tick_step(span);
  const double largest = std::max(std::abs(range.low), std::abs(range.high));
  const int digits = std::clamp(int(std::floor(std::log10(largest / step))) + 2, 6, 15);
  std::vector<AxisTick> ticks;
  const double first = std::ceil(range.low / step - 1e-6),
               last = std::floor(range.high / step + 1e-6);
  for (int k = 0; k <= int(last - first); ++k) {
    const double value = (first + k) * step;
    ticks.push_back({(value - range.low) / span, short_number(value, digits)});
  }
  return ticks;
}

}  // namespace elastogen
