// SPDX-License-Identifier: Apache-2.0
#include "bench/timing.hpp"

#include "io/report_file.hpp"

#include <malloc.h>
#include <unistd.h>

#include <chrono>
#include <fstream>

namespace elastogen::bench {

Spread spread_of(const std::vector<double>& ms) {
  return {quantile(ms, 0.25), quantile(ms, 0.5), quantile(ms, 0.75)};
}

Spread milliseconds(int repeats, const std::function<void()>& body,
                    const std::function<void()>& wait) {
  using Clock = std::chrono::steady_clock;
  std::vector<double> ms;
  body();
  for (int k = 0; k < repeats; ++k) {
    wait();
    const auto begin = Clock::now();
    body();
    wait();
    ms.push_back(std::chrono::duration<double, std::milli>(Clock::now() - begin).count());
  }
  return spread_of(ms);
}

int64_t resident_bytes() {
  malloc_trim(0);
  std::ifstream file("/proc/self/statm");
  int64_t size = 0, resident = 0;
  file >> size >> resident;
  return resident * sysconf(_SC_PAGESIZE);
}

}  // namespace elastogen::bench
