// SPDX-License-Identifier: Apache-2.0
#include "cli/exit_code.hpp"
#include "cli/verbs.hpp"
#include "core/parallel.hpp"
#include "scene/asset_stages.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <optional>
#include <string_view>

namespace elastogen {
namespace {

using Json = nlohmann::ordered_json;

/// The result of the check: findings and counts, or why the file cannot be used.
struct Diagnosis {
  RunReport report;
  std::string error;
  ExitCode code = kExitDone;
};

Diagnosis diagnose(const AnimateOptions& options) {
  Diagnosis d;
  try {
    voxelize_asset(options, d.report);
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::kAsset) throw;
    d.error = error.what();
    d.code = kExitAsset;
  }
  return d;
}

void print_json(const Diagnosis& d, const std::string& path) {
  Json findings = Json::array();
  for (const Finding& f : d.report.asset.findings) {
    const FindingKind& kind = kind_of(f);
    findings.push_back({{"what", f.what},
                        {"severity", severity_name(kind.severity)},
                        {"count", f.count},
                        {"text", f.text},
                        {"done", kind.done},
                        {"change", kind.change}});
  }
  const Json json = {{"path", path},
                     {"usable", d.code == kExitDone},
                     {"error", d.error},
                     {"format", d.report.asset.format},
                     {"closed", d.report.asset.closed},
                     {"voxels", d.report.voxels},
                     {"h", d.report.h},
                     {"findings", findings},
                     {"warnings", d.report.warnings}};
  fmt::print("{}\n", json.dump(2, ' ', false, Json::error_handler_t::replace));
}

void print_text(const Diagnosis& d, const std::string& path) {
  const RunReport& r = d.report;
  if (d.code == kExitDone)
    fmt::print("{}: usable: {}, {}, {} voxels of {:.4g} m\n", path, r.asset.format,
               r.asset.closed ? "closed" : "open", r.voxels, r.h);
  else
    fmt::print("{}: not usable\n", path);
  for (const Severity severity : {Severity::kWarning, Severity::kNote})
    for (const std::string& line : finding_lines(r.asset.findings, severity))
      fmt::print("  {}: {}\n", severity_name(severity), line);
  for (const std::string& warning : r.warnings) fmt::print("  warning: {}\n", warning);
  if (r.asset.findings.empty() && d.code == kExitDone) fmt::print("  nothing is odd\n");
}

}  // namespace

int doctor(const DoctorTask& task) {
  std::optional<ThreadLimit> threads;
  if (task.scene.threads > 0) threads.emplace(task.scene.threads);
  const Diagnosis d = diagnose(task.scene);
  (task.json ? print_json : print_text)(d, task.scene.input);
  if (d.code != kExitDone) fmt::print(stderr, "elastogen: {}\n", d.error);
  return d.code;
}

}  // namespace elastogen
