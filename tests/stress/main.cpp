// SPDX-License-Identifier: Apache-2.0
// stress: the short set; stress all; stress list; stress PREFIX ...: the cases whose names begin
// so. Prints a line a case; ends with 0 only if every case passed.
#include "core/error.hpp"
#include "tests/stress/cases.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <map>

namespace elastogen::stress {
namespace {

constexpr const char* kTorsion =
    "the torsion correction holds its rotations over a step; in folded voxels the new ones bring "
    "energy and a torque";
constexpr const char* kConcave =
    "implicit Euler gains energy where the elastic energy is concave along the step";

constexpr const char* kRows =
    "rows of eight voxels are mostly empty in needles and sheets: more memory a voxel than a solid";

/// Cases that fail, and why; of the random starts those of the short set (docs/tests.md,
/// stress catalogue).
const std::map<std::string, const char*> kKnownFailures = {
    {"start.random.stable.1", kTorsion},
    {"start.random.stable.4", kConcave},
    {"start.random.stable.5", kConcave},
    {"start.random.stable.7", kTorsion},
    {"start.random.corotated.7", kTorsion},
    {"start.flat.point.corotated", kTorsion},
    {"start.twisted.180.corotated", kConcave},
    {"start.twisted.180.stvk", kConcave},
    {"start.random.stvk.0", kTorsion},
    {"start.random.stvk.1", kTorsion},
    {"start.random.stvk.3", kTorsion},
    {"start.random.stvk.5", kTorsion},
    {"start.random.stvk.6", kTorsion},
    {"start.random.stvk.7", kTorsion},
    {"gravity.1e4", kTorsion},
    {"shape.needle.10000", kRows},
    {"shape.sheet.300", kRows},
};

bool known(const Record& r) {
  return kKnownFailures.contains(r.name);
}

std::vector<Case> all_cases() {
  std::vector<Case> cases;
  for (const auto& part : {start_cases(), shape_cases(), material_cases(), time_cases(),
                           load_cases(), size_cases(), input_cases(), solver_cases()})
    cases.insert(cases.end(), part.begin(), part.end());
  return cases;
}

bool chosen(const Case& c, const std::vector<std::string>& words) {
  if (words.empty() || words[0] == "check") return c.brief;
  return std::any_of(words.begin(), words.end(),
                     [&](const std::string& w) { return w == "all" || c.name.starts_with(w); });
}

/// A case that throws has failed, the others go on.
Record carry_out(const Case& c) {
  Record record;
  record.name = c.name;
  const auto begin = std::chrono::steady_clock::now();
  try {
    c.run(record);
  } catch (const std::exception& error) {
    record.faults.push_back(concat("stopped: ", error.what()));
  }
  record.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return record;
}

void print(const Record& r) {
  std::vector<int> sorted = r.iterations;
  std::sort(sorted.begin(), sorted.end());
  std::string work;
  if (!sorted.empty())
    work = concat("; ", sorted.size(), " steps; iterations ", sorted[sorted.size() / 2], " worst ",
                  sorted.back(), "; float64 ", r.float64 ? "yes" : "no");
  std::printf("%-6s %s; %s%s; %.2f s\n", r.faults.empty() ? "pass" : "FAIL", r.name.c_str(),
              r.label.empty() ? "done" : r.label.c_str(), work.c_str(), r.seconds);
  for (const std::string& note : r.notes) std::printf("         %s\n", note.c_str());
  for (const std::string& fault : r.faults) std::printf("         FAULT %s\n", fault.c_str());
  if (!r.faults.empty() && known(r)) std::printf("         known: %s\n", kKnownFailures.at(r.name));
  std::fflush(stdout);
}

/// How the cases of a family ended, where it has many.
void print_families(const std::vector<Record>& records) {
  std::map<std::string, std::map<std::string, int>> families;
  for (const Record& r : records)
    if (r.name.starts_with("start.random"))
      ++families[r.name.substr(0, r.name.rfind('.'))][r.label];
  for (const auto& [family, labels] : families) {
    std::printf("%s:", family.c_str());
    for (const auto& [label, count] : labels) std::printf(" %d %s;", count, label.c_str());
    std::printf("\n");
  }
}

int summary(const std::vector<Record>& records, bool forgive_known) {
  print_families(records);
  // iterations and passes of all cases
  std::vector<int> iterations;
  double first_float64 = 1e300;
  size_t passed = 0;
  for (const Record& r : records) {
    iterations.insert(iterations.end(), r.iterations.begin(), r.iterations.end());
    first_float64 = std::min(first_float64, r.first_float64);
    passed += r.faults.empty();
  }
  std::sort(iterations.begin(), iterations.end());
  if (!iterations.empty())
    std::printf("iterations a step: %d ... %d, median %d of %zu steps\n", iterations.front(),
                iterations.back(), iterations[iterations.size() / 2], iterations.size());
  if (first_float64 < 1e300)
    std::printf("smallest float floor of a step in float64: %.1e\n", first_float64);
  std::printf("%zu/%zu passed\n", passed, records.size());
  // failures; known ones may be forgiven
  for (const Record& r : records)
    if (!r.faults.empty())
      std::printf("failed%s: %s: %s\n", known(r) ? " (known)" : "", r.name.c_str(),
                  r.faults[0].c_str());
  const bool good = std::all_of(records.begin(), records.end(), [&](const Record& r) {
    return r.faults.empty() || (forgive_known && known(r));
  });
  return good && !records.empty() ? 0 : 1;
}

int answer(const std::vector<std::string>& words) {
  const std::vector<Case> cases = all_cases();
  if (words == std::vector<std::string>{"list"}) {
    for (const Case& c : cases) std::printf("%s%s\n", c.name.c_str(), c.brief ? "" : " (all)");
    return 0;
  }
  std::vector<Record> records;
  for (const Case& c : cases) {
    if (!chosen(c, words)) continue;
    records.push_back(carry_out(c));
    print(records.back());
  }
  return summary(records, words == std::vector<std::string>{"check"});
}

}  // namespace
}  // namespace elastogen::stress

int main(int argc, char** argv) {
  return elastogen::stress::answer({argv + 1, argv + argc});
}
