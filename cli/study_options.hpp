// SPDX-License-Identifier: Apache-2.0
// The options of study alone.

#pragma once

#include "cli/options.hpp"

namespace CLI {
class App;
}

namespace elastogen {

/// Options of study that are names.
struct StudyNames {
  std::vector<std::string> explicit_dts = {"1e-5"};
  std::string reference = "hex-bbar";
  std::vector<std::string> solvers = {"quasi", "newton", "paper"};
};

void add_study_options(CLI::App& app, StudyTask& task, StudyNames& names);

/// @throws Error (usage) naming an option that is out of range.
void resolve_study(const StudyNames& names, StudyTask& task);

}  // namespace elastogen
