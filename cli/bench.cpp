// SPDX-License-Identifier: Apache-2.0
#include "bench/bench.hpp"

#include "cli/exit_code.hpp"
#include "cli/study_machine.hpp"
#include "cli/verbs.hpp"
#include "core/cuda/card.hpp"
#include "core/parallel.hpp"
#include "io/safe_file.hpp"
#include "scene/version.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <optional>

namespace elastogen {
namespace {

/// What was run, by which build, on which machine, and how fast that copies.
bench::Json header(const BenchVerb& verb, const bench::CopyRates& rates) {
  const StudyMachine machine = this_machine();
  const bool card = rates.card > 0;
  fmt::print("{}, {} cores: copy {:.1f} GB/s, read and written\n", machine.cpu, machine.cores,
             1e-9 * rates.host);
  if (card) fmt::print("{}: copy {:.2f} TB/s\n", cuda::device_name(), 1e-12 * rates.card);
  return {
      {"command", verb.command},
      {"version", version_text()},
      {"commit", build_commit()},
      {"date", utc_date()},
      {"machine",
       {{"cpu", machine.cpu},
        {"cores", machine.cores},
        {"threads", verb.threads > 0 ? verb.threads : machine.cores},
        {"memory_bytes", machine.memory_bytes}}},
      {"card", card ? bench::Json(cuda::device_name()) : bench::Json(nullptr)},
      {"copy_bytes_per_second",
       {{"host", rates.host}, {"card", card ? bench::Json(rates.card) : bench::Json(nullptr)}}}};
}

/// Whether every step met its tolerance and every run of the baseline ended well.
bool complete(const bench::Json& result) {
  bool good = true;
  if (result.contains("step"))
    for (const bench::Json& row : result["step"]) good &= row["converged"].get<bool>();
  if (result.contains("baseline"))
    for (const bench::Json& one : result["baseline"])
      for (const bench::Json& row : one["rows"]) good &= !row.contains("exit_code");
  return good;
}

}  // namespace

int bench_verb(const BenchVerb& verb) {
  std::optional<ThreadLimit> threads;
  if (verb.threads > 0) threads.emplace(verb.threads);
  const bench::CopyRates rates = copy_rates(verb.task);
  bench::Json result = header(verb, rates);
  for (const std::string& part : verb.task.parts) {
    result[part] = measure(part, verb.task, rates);
    // write after each part, so that a failure in a later part loses nothing
    if (!verb.json.empty()) write_file(verb.json, result.dump(1) + "\n");
  }
  return complete(result) ? kExitDone : kExitDraft;
}

}  // namespace elastogen
