// SPDX-License-Identifier: Apache-2.0
#include "io/report_file.hpp"

#include "core/error.hpp"
#include "io/ledger_json.hpp"
#include "io/safe_file.hpp"

#include <nlohmann/json.hpp>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>

namespace elastogen {

using Json = nlohmann::ordered_json;

namespace {

Json to_json(const AssetSummary& asset) {
  Json findings = Json::array();
  for (const Finding& finding : asset.findings)
    findings.push_back({{"what", finding.what},
                        {"severity", severity_name(kind_of(finding).severity)},
                        {"count", finding.count},
                        {"text", finding.text}});
  const Provenance &size = asset.size.from, &up = asset.up.from;
  return {{"path", asset.path},
          {"format", asset.format},
          {"vertices", asset.vertices},
          {"faces", asset.faces},
          {"closed", asset.closed},
          {"size",
           {{"longest_edge", asset.size.longest_edge},
            {"guessed", size.guessed},
            {"reason", size.reason}}},
          {"up", {{"axis", up_name(asset.up.up)}, {"guessed", up.guessed}, {"reason", up.reason}}},
          {"findings", findings}};
}

Json to_json(const std::vector<Material>& materials, const std::vector<std::string>& nets) {
  Json list = Json::array();
  for (size_t m = 0; m < materials.size(); ++m) {
    const Material& material = materials[m];
    list.push_back({{"name", material.name},
                    {"law", law_name(material.law)},
                    {"young", material.young},
                    {"poisson", material.poisson},
                    {"density", material.density},
                    {"loss_factor", material.loss_factor.value_or(0)},
                    {"loss_frequency", material.loss_frequency}});
    if (m < nets.size() && !nets[m].empty()) list.back()["net"] = nets[m];
  }
  return list;
}

Json to_json(const StageSeconds& seconds) {
  return {{"read", seconds.read},
          {"voxelize", seconds.voxelize},
          {"setup", seconds.setup},
          {"steps", seconds.steps},
          {"write", seconds.write}};
}

Json to_json(const RunMeshError& error) {
  return {{"rms", error.rms},
          {"largest", error.largest},
          {"largest_motion", error.largest_motion},
          {"frames", error.frames},
          {"untrusted", error.untrusted}};
}

/// What not every run has.
void add_parts(const RunReport& report, Json& json) {
  if (report.mesh_error.frames > 0) json["mesh_error"] = to_json(report.mesh_error);
  if (!report.reactions.empty())
    json["reactions"] = reactions_json(report.reactions, report.holders);
  if (report.ledger.steps > 0) json["ledger"] = ledger_json(report.ledger);
}

}  // namespace

double quantile(std::vector<double> values, double q) {
  ELASTOGEN_CHECK(q >= 0 && q <= 1, "a quantile needs 0 <= q <= 1, got ", q);
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const double place = q * static_cast<double>(values.size() - 1);
  const auto below = static_cast<size_t>(place);
  const size_t above = std::min(below + 1, values.size() - 1);
  return values[below] + (place - std::floor(place)) * (values[above] - values[below]);
}

int64_t peak_memory_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return int64_t{1024} * usage.ru_maxrss;
}

void write_report(const std::string& path, const RunReport& report) {
  Json json = {
      {"asset", to_json(report.asset)},
      {"voxels", report.voxels},
      {"nodes", report.nodes},
      {"h", report.h},
      {"materials", to_json(report.materials, report.nets)},
      {"device", report.device},
      {"steps", report.steps},
      {"frames", report.frames},
      {"converged_share", report.converged_share},
      {"solved_share", report.solved_share},
      {"worst_residual", report.worst_residual},
      {"min_j", report.min_j},
      {"time_error",
       {{"sum", report.time_error},
        {"largest_of_a_frame", report.largest_time_error},
        {"frames_over", report.frames_over},
        {"loosest_tolerance", report.loosest_tolerance},
        {"solves", report.solves},
        {"rejected", report.rejected_steps}}},
      {"damped", report.damped},
      {"outside_fit", report.outside_fit},
      {"long_steps", report.long_steps},
      {"stage_seconds", to_json(report.stage_seconds)},
      {"ms_per_step",
       {{"median", quantile(report.step_ms, 0.5)}, {"p95", quantile(report.step_ms, 0.95)}}},
      {"peak_memory_bytes", report.peak_memory_bytes},
      {"notes", report.notes},
      {"warnings", report.warnings},
      {"command", report.command},
      {"commit", report.commit},
  };
  add_parts(report, json);
  // file names need not be UTF-8: invalid bytes are replaced
  write_file(path, json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n');
}

}  // namespace elastogen
