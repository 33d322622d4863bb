// SPDX-License-Identifier: Apache-2.0
// Times with their spread, and memory in use.

#pragma once

#include <cstdint>
#include <functional>
#include <vector>

namespace elastogen::bench {

/// Quartiles of some times [ms].
struct Spread {
  double lower = 0, median = 0, upper = 0;
};

Spread spread_of(const std::vector<double>& ms);

/// Runs the body once to warm up, then as often as asked for; wait() before and after each run lets
/// a device come to rest.
Spread milliseconds(
    int repeats, const std::function<void()>& body, const std::function<void()>& wait = [] {});

/// Memory of this process that is resident now [bytes]; what was freed has been given back.
int64_t resident_bytes();

}  // namespace elastogen::bench
