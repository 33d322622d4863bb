// SPDX-License-Identifier: Apache-2.0
#include "io/step_log.hpp"

#include "core/error.hpp"

#include <nlohmann/json.hpp>

namespace elastogen {

std::string step_log_line(int64_t frame, const StepReport& report,
                          const std::optional<CloudReport>& cloud) {
  const EnergyParts& energy = report.energy;
  // what every step has
  nlohmann::ordered_json line = {
      {"frame", frame},
      {"step", report.step},
      {"time", report.time},
      {"converged", report.converged},
      {"residual", report.residual},
      {"outer", report.outer},
      {"inner", report.inner},
      {"scheme", report.scheme == TimeScheme::kBdf2 ? "bdf2" : "euler"},
      {"float64", report.float64},
      {"finite", report.finite},
      {"min_j", report.min_j},
      {"min_corner_j", report.min_corner_j},
      {"outside_fit", report.outside_fit},
      {"energies",
       {{"kinetic", energy.kinetic},
        {"elastic", energy.elastic},
        {"hourglass", energy.hourglass},
        {"gravity", energy.gravity},
        {"contact", energy.contact}}},
      {"active_share", report.active_share},
      {"deepest_overlap", report.deepest_overlap},
      {"ms", report.ms},
  };
  // what only bodies that yield and particles have
  if (report.yields) line["energies"]["plastic"] = energy.plastic;
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
  file_ << step_log_line(frame, report, cloud) << '\n' << std::flush;
  if (!file_) throw Error(concat(path_, ": writing failed, disk full?"), ErrorKind::kResources);
}

}  // namespace elastogen
