// SPDX-License-Identifier: Apache-2.0
#include "core/parallel.hpp"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>

#ifdef __SANITIZE_THREAD__
#include <atomic>
#include <thread>
#endif

namespace elastogen {

struct ThreadLimit::Control {
  tbb::global_control value;
};

ThreadLimit::ThreadLimit(int threads)
    : control_(new Control{{tbb::global_control::max_allowed_parallelism, size_t(threads)}}) {}
ThreadLimit::~ThreadLimit() = default;

int thread_count() {
  return int(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

void run_ranges(int64_t tasks, const void* task, void (*call)(const void*, int64_t, int64_t)) {
#ifdef __SANITIZE_THREAD__
  // the sanitizer cannot see into TBB's scheduler, whose hand-overs look like races to it
  std::atomic<int64_t> next = 0;
  const auto work = [&] {
    for (int64_t b; (b = next++) < tasks;) call(task, b, b + 1);
  };
  std::thread other(work);
  work();
  other.join();
#else
  tbb::parallel_for(tbb::blocked_range<int64_t>(0, tasks),
                    [=](const auto& range) { call(task, range.begin(), range.end()); });
#endif
}

}  // namespace elastogen
