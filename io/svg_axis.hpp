// SPDX-License-Identifier: Apache-2.0
// Axes of plots: their range, the place of a value on them, and their ticks.

#pragma once

#include <string>
#include <vector>

namespace elastogen {

/// The range of an axis, in values or in their decadic logarithms.
struct AxisRange {
  bool log = false;
  double low = 0, high = 1;  ///< low < high

  /// Place of a value that can be drawn, 0 at the low end and 1 at the high one: the share
  /// (value - low)/(high - low), with log10(value) on a logarithmic axis.
  double share(double value) const;
};

struct AxisTick {
  double share = 0;
  std::string text;  ///< "" for one between the others
};

/// Whether a value can be drawn on such an axis: at most 1e300 in size, and positive if the axis is
/// logarithmic.
bool can_be_drawn(double value, bool log);

/// The range from tick to tick around the values: ticks at decades, or at multiples of a step of 1,
/// 2 or 5 times a power of ten that is at least a fifth of the span of the values. Equal values v
/// get v +- max(|v|/10, 1 if v is 0), or the decade on both sides.
/// @param values  that can be drawn; none give 0 ... 1, or one decade from 1.
AxisRange range_around(const std::vector<double>& values, bool log);

/// Ticks within the range: at each decade (every second, third, ... of more than eight), on up to
/// four decades with ticks at 2 ... 9 between them; or at multiples of a step as in range_around.
/// Texts are like 1e-4, or like 0.01 on axes within 1e-3 ... 1e4.
std::vector<AxisTick> axis_ticks(const AxisRange& range);

}  // namespace elastogen
