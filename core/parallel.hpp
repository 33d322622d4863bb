// SPDX-License-Identifier: Apache-2.0
// The CPU loops, on TBB. Results never depend on the number of threads: bodies write disjoint
// places, and sums are formed block by block and added in the order of the blocks.

#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace elastogen {

inline constexpr int64_t kBlock = 2048;

/// Limits the threads of all loops while it lives.
class ThreadLimit {
 public:
  explicit ThreadLimit(int threads);
  ~ThreadLimit();
  ThreadLimit(const ThreadLimit&) = delete;
  ThreadLimit& operator=(const ThreadLimit&) = delete;

 private:
  struct Control;
  std::unique_ptr<Control> control_;
};

/// The most threads that a loop may have now.
int thread_count();

/// Calls call(task, begin, end) for ranges that make up [0, tasks), in any order: the one loop of TBB
/// under all loops, so that its templates are compiled once.
void run_ranges(int64_t tasks, const void* task, void (*call)(const void*, int64_t, int64_t));

/// Calls task(b) for each b of [0, tasks), in any order.
template <class Task>
void run_tasks(int64_t tasks, const Task& task) {
  // the loop over a range is inside, where the compiler sees the task: outside it cost 6 % of a step
  run_ranges(tasks, &task, [](const void* t, int64_t begin, int64_t end) {
    const Task& run = *static_cast<const Task*>(t);
    for (int64_t b = begin; b < end; ++b) run(b);
  });
}

/// Calls body(begin, end) for the blocks of [0, n).
template <class Body>
void for_blocks(int64_t n, const Body& body, int64_t block = kBlock) {
  const int64_t blocks = (n + block - 1) / block;
  if (blocks <= 1) {
    if (n > 0) body(int64_t(0), n);
    return;
  }
  run_tasks(blocks, [&](int64_t b) { body(b * block, std::min(n, (b + 1) * block)); });
}

/// Calls body(i) for each i of [0, n).
template <class Body>
void for_each(int64_t n, const Body& body, int64_t block = kBlock) {
  for_blocks(
      n,
      [&](int64_t begin, int64_t end) {
        for (int64_t i = begin; i < end; ++i) body(i);
      },
      block);
}

/// The i of [0, n) of each group, in order. group(i) is called twice for each i; a value below 0
/// means no group.
template <class Group>
std::vector<std::vector<int32_t>> grouped(int64_t n, size_t groups, const Group& group) {
  const int64_t blocks = (n + kBlock - 1) / kBlock;
  std::vector<int32_t> next(size_t(blocks) * groups);
  for_blocks(n, [&](int64_t begin, int64_t end) {
    int32_t* count = next.data() + size_t(begin / kBlock) * groups;
    for (int64_t i = begin; i < end; ++i)
      if (const int64_t g = group(i); g >= 0) ++count[g];
  });
  std::vector<int32_t> size(groups);
  for (size_t k = 0; k < next.size(); ++k)
    size[k % groups] += std::exchange(next[k], size[k % groups]);
  std::vector<std::vector<int32_t>> result(groups);
  for (size_t g = 0; g < groups; ++g) result[g].resize(size_t(size[g]));
  for_blocks(n, [&](int64_t begin, int64_t end) {
    int32_t* place = next.data() + size_t(begin / kBlock) * groups;
    for (int64_t i = begin; i < end; ++i)
      if (const int64_t g = group(i); g >= 0) result[size_t(g)][size_t(place[g]++)] = int32_t(i);
  });
  return result;
}

/// The i of [0, n) with keep(i), in order; keep is called twice for each i.
template <class Keep>
std::vector<int32_t> filtered(int64_t n, const Keep& keep) {
  return std::move(grouped(n, 1, [&](int64_t i) { return keep(i) ? 0 : -1; })[0]);
}

/// Sum over the blocks of partial(begin, end), a double; same bits on any number of threads.
template <class Partial>
double ordered_sum(int64_t n, const Partial& partial) {
  const int64_t blocks = (n + kBlock - 1) / kBlock;
  std::vector<double> sums(static_cast<size_t>(blocks));
  for_blocks(n, [&](int64_t begin, int64_t end) {
    sums[static_cast<size_t>(begin / kBlock)] = partial(begin, end);
  });
  double sum = 0;
  for (const double s : sums) sum += s;
  return sum;
}

}  // namespace elastogen
