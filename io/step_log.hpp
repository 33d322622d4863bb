// SPDX-License-Identifier: Apache-2.0
// `--log-json`: one JSON object for each time step, one a line (docs/formats.md, log).

#pragma once

#include "core/report.hpp"

#include <fstream>
#include <optional>
#include <string>

namespace elastogen {

/// Extent and volume of the particles after a step.
struct CloudReport {
  Vec3 lower = {1e300, 1e300, 1e300}, upper = {-1e300, -1e300, -1e300};  ///< box of all [m]
  double volume = 0;  ///< sum V det F of their elastic F [m^3]
};

/// Appends a line a step to a new file, which can be read during the run. A number that is not
/// finite is written as null.
class StepLog {
 public:
  /// @throws Error (resources) if the file cannot be made.
  explicit StepLog(const std::string& path);

  /// @param frame  the frame that the step belongs to, counted from 1.
  /// @param cloud  for steps of particles
  /// @throws Error (resources) if the disk refuses the line.
  void write(int64_t frame, const StepReport& report, const std::optional<CloudReport>& cloud = {});

 private:
  std::string path_;
  std::ofstream file_;
};

/// The line that StepLog writes, without the line break.
std::string step_log_line(int64_t frame, const StepReport& report,
                          const std::optional<CloudReport>& cloud = {});

}  // namespace elastogen
