// SPDX-License-Identifier: Apache-2.0
// Times with their spread, and memory use.

#pragma once

#include <cstdint>
#include <functional>
#include <vector>

namespace elastogen::bench {

/// Quartiles of times [ms].
struct Spread {
  double lower = 0, median = 0, upper = 0;
};

Spread spread_of(const std::vector<double>& ms);

/// Runs the body once to warm up, then as often as asked for. wait() before and after each run lets
/// a device finish its work.
Spread milliseconds(
    int repeats, const std::function<void()>& body, const std::function<void()>& wait = [] {});

/// Resident memory of this process [bytes], after freed memory has been returned to the system.
int64_t resident_bytes();

}  // namespace elastogen::bench
