// SPDX-License-Identifier: Apache-2.0
// The command line of `materials`.

#pragma once

#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace elastogen {

/// Task of `elastogen materials`.
struct MaterialsTask {
  enum class Action { kList, kShow, kReport, kGenerate, kFit };
  Action action = Action::kList;
  std::string name;               ///< preset, law, sum of laws or file
  std::optional<double> poisson;  ///< unset: the preset's, or the verb's own
  std::vector<std::string> laws;  ///< laws to fit; none: all
  std::string output;
  bool json = false;
  std::string command;  ///< as typed
};

/// Adds the verb, whose options are parsed into the task. The task must outlive the parser.
CLI::App* add_materials(CLI::App& app, MaterialsTask& task);

}  // namespace elastogen
