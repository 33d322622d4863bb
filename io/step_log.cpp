// SPDX-License-Identifier: Apache-2.0
#include "io/step_log.hpp"

#include "core/error.hpp"
#include "core/step_verdict.hpp"
#include "core/time_scheme.hpp"
#include "io/ledger_json.hpp"

#include <nlohmann/json.hpp>

namespace elastogen {

namespace {

nlohmann::ordered_json energies(const StepReport& report) {
  const EnergyParts& energy = report.energy;
  nlohmann::ordered_json json = {{"kinetic", energy.kinetic},
                                 {"elastic", energy.elastic},
                                 {"hourglass", energy.hourglass},
                                 {"gravity", energy.gravity},
                                 {"contact", energy.contact}};
  if (report.yields) json["plastic"] = energy.plastic;
  return json;
}

/// What only steps of the network and of stages have, and what only the latter.
void add_stages(const StepReport& report, nlohmann::ordered_json& line) {
  line["length"] = report.length;
  line["solves"] = report.solves;
  line["rejected"] = report.rejected;
  line["tolerance"] = report.tolerance;
  line["time_error"] = report.time_error;
  line["damped"] = report.damped;
  if (!report.ledger.known) return;
  line["time_ratio"] = report.time_ratio;
  line["ledger"] = ledger_json(report.ledger);
}

nlohmann::ordered_json to_json(const MeshError& error) {
  return {{"rms", error.rms}, {"largest", error.largest}, {"trusted", error.trusted}};
}

}  // namespace

std::string step_log_line(int64_t frame, const StepReport& report,
                          const std::optional<CloudReport>& cloud) {
  // what every step has
  nlohmann::ordered_json line = {
      {"frame", frame},
      {"step", report.step},
      {"time", report.time},
      {"converged", is_converged(report)},
      {"residual", report.residual},
      {"outer", report.outer},
      {"inner", report.inner},
      {"scheme", scheme_name(report.scheme)},
      {"float64", report.float64},
      {"finite", report.finite},
      {"min_j", report.min_j},
      {"min_corner_j", report.min_corner_j},
      {"outside_fit", report.outside_fit},
      {"energies", energies(report)},
      {"active_share", report.active_share},
      {"deepest_overlap", report.deepest_overlap},
      {"ms", report.ms},
  };
  if (report.length > 0) add_stages(report, line);
  // what only held bodies and ends of frames have, and bodies that yield and particles
  if (!report.reactions.empty()) line["reactions"] = reactions_json(report.reactions);
  if (report.mesh_error) line["mesh_error"] = to_json(*report.mesh_error);
  if (report.yields || cloud) line["fallbacks"] = report.fallbacks;
  if (cloud)
    line["particles"] = {
        {"lower", cloud->lower}, {"upper", cloud->upper}, {"volume", cloud->volume}};
  return line.dump();  // numbers that are not finite become null
}

StepLog::StepLog(const std::string& path) : path_(path), file_(path, std::ios::trunc) {
  if (!file_) throw Error(concat(path, ": cannot be written"), ErrorKind::kResources);
}

void StepLog::write(int64_t frame, const StepReport& report,
                    const std::optional<CloudReport>& cloud) {
  // one write with its line break: a kill between two writes leaves whole lines
  file_ << step_log_line(frame, report, cloud) + '\n' << std::flush;
  if (!file_) throw Error(concat(path_, ": writing failed, disk full?"), ErrorKind::kResources);
}

}  // namespace elastogen
