// SPDX-License-Identifier: Apache-2.0
// Whether a step counts as converged in files and summaries.

#pragma once

#include "core/report.hpp"

namespace elastogen {

/// Two of the three numbers of a step are as asked for: its residual, and its time error where one is
/// estimated. At the most steps `auto` takes a step as it is, with a time error above that.
inline bool is_converged(const StepReport& report) {
  return report.converged && report.time_ratio <= 1;
}

}  // namespace elastogen
