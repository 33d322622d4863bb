// SPDX-License-Identifier: Apache-2.0
// Axes of plots: what they span, where a value lies on them, and their ticks.

#pragma once

#include <string>
#include <vector>

namespace elastogen {

/// The range of an axis: of the values, or of their decadic logarithms.
struct AxisRange {
  bool log = false;
  double low = 0, high = 1;  ///< low < high

  /// Place of a value that can be drawn, 0 at the low end and 1 at the high one:
  /// (value - low)/(high - low), or the same of log10(value).
  double share(double value) const;
};

struct AxisTick {
  double share = 0;
  std::string text;  ///< "" for one between the others
};

/// Whether the value has a place on such an axis: at most 1e300 in size, and positive on a
/// logarithmic one.
bool can_be_drawn(double value, bool log);

/// The range that ends at ticks around the values: at decades, or at multiples of a step of 1, 2
/// or 5 times a power of ten, at least a fifth of what the values span. Equal values v get
/// v +- max(|v|/10, 1 if v is 0), or the decade on both sides.
/// @param values  that can be drawn; none give 0 ... 1, or one decade from 1.
AxisRange range_around(const std::vector<double>& values, bool log);

/// Ticks within the range: at each decade (of more than eight every second, third, ...) with
/// those at 2 ... 9 between them on up to four decades, or at multiples of a step as above. Their
/// texts are 1e-4, and 0.01 on axes within 1e-3 ... 1e4.
std::vector<AxisTick> axis_ticks(const AxisRange& range);

}  // namespace elastogen
