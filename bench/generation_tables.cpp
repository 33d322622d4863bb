// SPDX-License-Identifier: Apache-2.0
#include "bench/generation_tables.hpp"

#include "core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace elastogen::bench {
namespace {

constexpr double kNearIncompressible = 0.48;

/// Indices of some of the materials.
struct Group {
  std::string name;
  std::vector<size_t> members;
};

std::vector<Group> groups_of(const Results& results) {
  std::vector<Group> groups;
  const auto add = [&](const std::string& name, const std::function<bool(const FitMaterial&)>& is) {
    groups.push_back({name, {}});
    for (size_t n = 0; n < results.materials.size(); ++n)
      if (is(results.materials[n])) groups.back().members.push_back(n);
    if (groups.back().members.empty()) groups.pop_back();
  };
  add("all", [](const FitMaterial&) { return true; });
  for (const MaterialGroup group : kMaterialGroups)
    add(group_name(group), [group](const FitMaterial& m) { return group_of(m) == group; });
  add("nu up to 0.48", [](const FitMaterial& m) { return m.poisson <= kNearIncompressible; });
  add("nu above 0.48", [](const FitMaterial& m) { return m.poisson > kNearIncompressible; });
  return groups;
}

double middle(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + int64_t(values.size()) / 2, values.end());
  return values[values.size() / 2];
}

double largest(const std::vector<double>& values) {
  return *std::max_element(values.begin(), values.end());
}

/// Results of a method on a group after some iterations.
struct Stage {
  double share = 0;                       ///< share inside all limits
  double median = 0, p99 = 0, worst = 0;  ///< of the stress: median net; worst: largest p99
  double fit_ms = 0;                      ///< median time of the fits
};

Stage stage_of(const Method& method, const Group& group, size_t k) {
  std::vector<double> median, p99, ms;
  int inside = 0;
  for (const size_t n : group.members) {
    const StartFit& fit = method.courses[n].fits[k];
    inside += fit.report.passes();
    median.push_back(fit.report.stress_median);
    p99.push_back(fit.report.stress_p99);
    ms.push_back(1e3 * fit.fit_seconds);
  }
  return {inside / double(group.members.size()), middle(median), middle(p99), largest(p99),
          middle(ms)};
}

/// Time to the first report that passes: the start, the fit up to there and all reports. Mean, and
/// the time that 99 of 100 materials keep. Materials that never pass are listed.
struct Passing {
  double mean_ms = 0, p99_ms = 0;
  std::vector<size_t> never;
};

Passing passing_of(const Method& method, const Group& group) {
  Passing passing;
  std::vector<double> ms;
  // time of each material until a report passes
  for (const size_t n : group.members) {
    const Course& course = method.courses[n];
    double seconds = course.start_seconds;
    bool inside = false;
    for (const StartFit& fit : course.fits) {
      seconds += fit.report_seconds;
      inside = fit.report.passes();
      if (!inside) continue;
      seconds += fit.fit_seconds;
      break;
    }
    if (inside)
      ms.push_back(1e3 * seconds);
    else
      passing.never.push_back(n);
  }
  // mean and 99th percentile of these
  if (ms.empty()) return passing;
  std::sort(ms.begin(), ms.end());
  for (const double value : ms) passing.mean_ms += value / double(ms.size());
  passing.p99_ms = ms[size_t(std::ceil(0.99 * double(ms.size()))) - 1];
  return passing;
}

double start_ms(const Method& method, const Group& group) {
  std::vector<double> ms;
  for (const size_t n : group.members) ms.push_back(1e3 * method.courses[n].start_seconds);
  return middle(ms);
}

void print_stages(const Results& results, const Group& all) {
  fmt::print(
      "| begins at | iterations | inside all limits | stress, median net: median [%] "
      "| p99 [%] | worst net: p99 [%] | fit [ms] |\n|---|---|---|---|---|---|---|\n");
  for (const Method& method : results.methods)
    for (size_t k = 0; k < kStages; ++k) {
      const Stage stage = stage_of(method, all, k);
      fmt::print("| {} | {} | {:.1f} % | {:.2g} | {:.2g} | {:.2g} | {:.0f} |\n", method.name,
                 kIterations[k], 100 * stage.share, 100 * stage.median, 100 * stage.p99,
                 100 * stage.worst, stage.fit_ms);
    }
}

void print_group(const Results& results, const Group& group) {
  fmt::print("\n{} ({} materials): inside all limits after iterations\n\n| begins at |", group.name,
             group.members.size());
  for (const int iterations : kIterations) fmt::print(" {} |", iterations);
  fmt::print(" start [ms] | passes after [ms] | 99 of 100 | never |\n|---|");
  for (size_t k = 0; k < kStages + 4; ++k) fmt::print("---|");
  fmt::print("\n");
  for (const Method& method : results.methods) {
    fmt::print("| {} |", method.name);
    for (size_t k = 0; k < kStages; ++k)
      fmt::print(" {:.1f} % |", 100 * stage_of(method, group, k).share);
    const Passing passing = passing_of(method, group);
    fmt::print(" {:.1f} | {:.0f} | {:.0f} | {} |\n", start_ms(method, group), passing.mean_ms,
               passing.p99_ms, passing.never.size());
  }
}

/// The codec alone on a group: share inside, errors of the median net.
Stage decoded_of(const Results& results, const Group& group) {
  std::vector<double> median, p99;
  int inside = 0;
  for (const size_t n : group.members) {
    inside += results.decoded[n].passes();
    median.push_back(results.decoded[n].stress_median);
    p99.push_back(results.decoded[n].stress_p99);
  }
  return {inside / double(group.members.size()), middle(median), middle(p99), largest(p99), 0};
}

// not-a-number and infinity are written as null
std::string number(double value) {
  return std::isfinite(value) ? fmt::format("{:.4g}", value) : "null";
}

std::string json_of(const Stage& stage) {
  return fmt::format(R"("inside": {}, "median": {}, "p99": {}, "worst_p99": {}, "fit_ms": {})",
                     number(stage.share), number(stage.median), number(stage.p99),
                     number(stage.worst), number(stage.fit_ms));
}

std::string json_of(const Results& results, const Method& method, const Group& group) {
  std::string stages;
  for (size_t k = 0; k < kStages; ++k)
    stages += fmt::format(R"({}{{"iterations": {}, {}}})", k ? ", " : "", kIterations[k],
                          json_of(stage_of(method, group, k)));
  const Passing passing = passing_of(method, group);
  std::string never;
  for (const size_t n : passing.never)
    never += concat(never.empty() ? "\"" : ", \"", results.materials[n].name, '"');
  return fmt::format(
      R"({{"start": "{}", "start_ms": {}, "passes_after_ms": {}, "passes_after_p99_ms": {}, )"
      R"("never": [{}], "stages": [{}]}})",
      method.name, number(start_ms(method, group)), number(passing.mean_ms), number(passing.p99_ms),
      never, stages);
}

}  // namespace

void print_tables(const Results& results) {
  const std::vector<Group> groups = groups_of(results);
  print_stages(results, groups[0]);
  for (const Group& group : groups) {
    print_group(results, group);
    if (results.decoded.empty()) continue;
    const Stage stage = decoded_of(results, group);
    fmt::print("\nthe codec alone, {} numbers: {:.1f} % inside, median {:.2g} %, p99 {:.2g} %\n",
               results.components, 100 * stage.share, 100 * stage.median, 100 * stage.p99);
  }
}

std::string json_of(const Results& results) {
  std::string groups;
  for (const Group& group : groups_of(results)) {
    std::string methods;
    for (const Method& method : results.methods)
      methods +=
          fmt::format("{}\n   {}", methods.empty() ? "" : ",", json_of(results, method, group));
    const std::string codec = results.decoded.empty()
                                  ? std::string("null")
                                  : fmt::format("{{{}}}", json_of(decoded_of(results, group)));
    groups += fmt::format(
        "{}\n {{\"group\": \"{}\", \"materials\": {}, \"codec\": {},\n  "
        "\"starts\": [{}]}}",
        groups.empty() ? "" : ",", group.name, group.members.size(), codec, methods);
  }
  return fmt::format("{{\"seed\": {}, \"strains\": {}, \"components\": {}, \"groups\": [{}]}}\n",
                     results.seed, results.strains, results.components, groups);
}

}  // namespace elastogen::bench
