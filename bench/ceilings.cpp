// SPDX-License-Identifier: Apache-2.0
// The machine's own limits: copy bandwidth, arithmetic, latency. CMake lets this file contract
// multiplications with additions.
#include "bench/bench.hpp"
#include "bench/card.hpp"
#include "bench/timing.hpp"
#include "core/cuda/card.hpp"
#include "core/parallel.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cstring>

namespace elastogen::bench {
namespace {

constexpr int kRepeats = 9;
constexpr int64_t kLarge = int64_t(1) << 28;  // bytes that no cache holds
constexpr int kRounds = 1'000'000;

double host_copy_rate() {
  const std::vector<char> from(size_t{kLarge}, 1);
  std::vector<char> to(from.size());
  const Spread ms = milliseconds(kRepeats, [&] {
    for_blocks(
        kLarge,
        [&](int64_t begin, int64_t end) {
          std::memcpy(to.data() + begin, from.data() + begin, size_t(end - begin));
        },
        int64_t(1) << 18);
  });
  return 2e3 * double(kLarge) / ms.median;
}

/// Twelve chains of multiply-adds on vectors of 32 bytes.
template <class T>
T multiply_add(T start) {
  typedef T Vector __attribute__((vector_size(32)));
  constexpr int kChains = 12;
  Vector x[kChains];
  for (int k = 0; k < kChains; ++k) x[k] = Vector{} + start + T(k);
  for (int r = 0; r < kRounds; ++r)
    for (int k = 0; k < kChains; ++k) x[k] = x[k] * T(0.999) + T(0.001);
  Vector sum = x[0];
  for (int k = 1; k < kChains; ++k) sum += x[k];
  return sum[0] + sum[1];
}

/// Multiplications and additions a second of so many threads.
template <class T>
double host_rate(int threads) {
  std::vector<T> out(static_cast<size_t>(threads));
  const Spread ms = milliseconds(kRepeats, [&] {
    run_tasks(threads, [&](int64_t k) { out[size_t(k)] = multiply_add(T(k)); });
  });
  return 2e3 * 12 * double(32 / sizeof(T)) * kRounds * threads / ms.median;
}

/// A parallel loop without work [us].
double loop_microseconds(int threads) {
  constexpr int kLoops = 1000;
  const Spread ms = milliseconds(kRepeats, [&] {
    for (int k = 0; k < kLoops; ++k) run_tasks(threads, [](int64_t) {});
  });
  return 1e3 * ms.median / kLoops;
}

Json host_ceilings() {
  const int all = thread_count();
  Json rows = Json::array();
  for (int threads = 1;; threads = std::min(2 * threads, all)) {
    const ThreadLimit limit(threads);
    const double copy = host_copy_rate(), single = host_rate<float>(threads);
    fmt::print("host, {} threads: copy {:.1f} GB/s, float {:.0f} GFLOP/s\n", threads, 1e-9 * copy,
               1e-9 * single);
    rows.push_back({{"threads", threads},
                    {"copy_bytes_per_second", copy},
                    {"float_flops_per_second", single},
                    {"double_flops_per_second", host_rate<double>(threads)},
                    {"parallel_loop_us", loop_microseconds(threads)}});
    if (threads == all) break;
  }
  return rows;
}

Json card_json() {
  const CardCeilings c = card_ceilings();
  fmt::print(
      "{}: copy {:.2f} TB/s, float {:.1f}, double {:.1f} TFLOP/s, launch {:.1f}, graph node "
      "{:.1f}, launch and wait {:.1f}, fetch {:.1f} us\n",
      cuda::device_name(), 1e-12 * c.copy, 1e-12 * c.float_rate, 1e-12 * c.double_rate, c.launch_us,
      c.graph_node_us, c.sync_us, c.fetch_us);
  return {{"name", cuda::device_name()},
          {"memory_bytes", c.memory_bytes},
          {"multiprocessors", c.multiprocessors},
          {"copy_bytes_per_second", c.copy},
          {"float_flops_per_second", c.float_rate},
          {"double_flops_per_second", c.double_rate},
          {"launch_us", c.launch_us},
          {"graph_node_us", c.graph_node_us},
          {"launch_and_wait_us", c.sync_us},
          {"fetch_us", c.fetch_us}};
}

}  // namespace

CopyRates copy_rates(const BenchTask& task) {
  return {host_copy_rate(), resolved(task.device) == Device::kCuda ? card_copy_rate() : 0};
}

Json measure_ceilings(const BenchTask& task) {
  Json result = {{"host", host_ceilings()}, {"card", nullptr}};
  if (resolved(task.device) == Device::kCuda) result["card"] = card_json();
  return result;
}

}  // namespace elastogen::bench
