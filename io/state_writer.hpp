// SPDX-License-Identifier: Apache-2.0
// `--state`: an HDF5 file that lets an outsider recompute every step of a run (docs/formats.md,
// state file).

#pragma once

#include "core/report.hpp"
#include "core/state.hpp"
#include "io/safe_file.hpp"

#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace elastogen {

/// What the file says of the run besides its scene.
struct StateHeader {
  double fps = 60;
  std::string solver;               ///< "quasi" or "newton"
  double tolerance = 1e-3;          ///< of the residual [-]
  std::string energy = "analytic";  ///< what gives the stress
  std::string commit;               ///< of the build
  /// parameters of the contact model, e.g. {"distance", 0.001}: attributes of /contact
  std::vector<std::pair<std::string, double>> contact;
};

/// Keeps every step in a raw file in the target's folder (without a name, so that the system frees
/// it however the process ends) and packs all of them into the target at the end.
class StateWriter {
 public:
  /// @param scene    finished; must outlive the writer.
  /// @param initial  the start, entry 0 of /steps/x, v and time.
  /// @throws Error (resources) if the raw file cannot be written; (usage) on wrong shapes.
  StateWriter(const std::string& path, const Scene& scene, const StateHeader& header,
              const State& initial);

  /// Adds the state after a time step and what the step said. Once a step, substeps included.
  /// @throws Error (resources) if the disk is full.
  void step(const State& state, const StepReport& report);

  /// Writes the file under a temporary name and renames it. Also for a run that ended early.
  /// @throws Error (resources)
  void finish();

 private:
  void keep(const State& state);

  const Scene& scene_;
  StateHeader header_;
  std::string path_;
  SafeFile spill_file_;                                    ///< never committed
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> spill_;  ///< x, v of each entry, raw float64
  std::vector<double> time_;                               ///< of each entry [s]
  std::vector<StepReport> reports_;                        ///< one less than entries
};

}  // namespace elastogen
