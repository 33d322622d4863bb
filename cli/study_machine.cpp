// SPDX-License-Identifier: Apache-2.0
#include "cli/study_machine.hpp"

#include "core/parallel.hpp"
#include "core/stopwatch.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <ctime>
#include <fstream>
#include <thread>

namespace elastogen {
namespace {

constexpr int64_t kLarge = int64_t(1) << 28;  // bytes that no cache holds
constexpr int kRepeats = 7;

std::string cpu_model() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

void copy(const std::vector<char>& from, std::vector<char>& to) {
  for_blocks(
      int64_t(from.size()),
      [&](int64_t begin, int64_t end) {
        std::memcpy(to.data() + begin, from.data() + begin, size_t(end - begin));
      },
      int64_t(1) << 18);
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + int64_t(values.size() / 2), values.end());
  return values[values.size() / 2];
}

}  // namespace

StudyMachine this_machine() {
  StudyMachine machine;
  machine.cpu = cpu_model();
  machine.cores = int64_t(std::thread::hardware_concurrency());
  machine.memory_bytes = int64_t(sysconf(_SC_PHYS_PAGES)) * sysconf(_SC_PAGESIZE);
  machine.copy_bandwidth = 2 * double(kLarge) * copies_per_second(kLarge);
  return machine;
}

double copies_per_second(int64_t bytes) {
  const std::vector<char> from(size_t(std::max<int64_t>(1, bytes)), 1);
  std::vector<char> to(from.size());
  const int64_t times = std::max<int64_t>(1, (int64_t(1) << 24) / int64_t(from.size()));
  copy(from, to);
  std::vector<double> rates;
  for (int k = 0; k < kRepeats; ++k) {
    const Stopwatch watch;
    for (int64_t n = 0; n < times; ++n) copy(from, to);
    rates.push_back(double(times) / watch.seconds());
  }
  return median(std::move(rates));
}

std::string utc_date() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

}  // namespace elastogen
