// SPDX-License-Identifier: Apache-2.0
// `--report`: input, results and quality of a run as one JSON file (docs/formats.md, report).

#pragma once

#include "core/holder.hpp"
#include "core/ledger.hpp"
#include "core/material.hpp"
#include "core/mesh_error.hpp"
#include "io/asset_pose.hpp"

#include <string>
#include <vector>

namespace elastogen {

struct AssetSummary {
  std::string path;
  std::string format;  ///< as Asset::format
  int64_t vertices = 0;
  int64_t faces = 0;  ///< triangles
  bool closed = false;
  SizeChoice size;
  UpChoice up;
  std::vector<Finding> findings;
};

/// Wall time of the stages [s].
struct StageSeconds {
  double read = 0, voxelize = 0, setup = 0, steps = 0, write = 0;
};

struct RunReport {
  AssetSummary asset;
  int64_t voxels = 0;
  int64_t nodes = 0;
  double h = 0;  ///< voxel edge [m]
  std::vector<Material> materials;
  std::vector<std::string> nets;  ///< SHA-256 of each material's weights, "": its law; empty: laws
  std::string device = "cpu";     ///< device of the iterations: "cpu", or the name of a card
  int64_t steps = 0;              ///< number of time steps
  int64_t frames = 0;             ///< frames written, without the rest frame
  double converged_share = 0;     ///< share of the steps, 0 ... 1 (core/step_verdict.hpp)
  double solved_share = 0;        ///< of the steps, whatever their time errors
  double worst_residual = 0;      ///< largest of all steps
  double min_j = 1;               ///< smallest det F of all steps
  double time_error = 0;          ///< estimates of the time error, summed over the steps [m]
  double loosest_tolerance = 0;   ///< of a step's residual, where it follows the time error
  double largest_time_error = 0;  ///< of a frame [m]
  int64_t frames_over = 0;        ///< with a step whose time error is above what was accepted
  RunMeshError mesh_error;        ///< of the frames that got a mesh number
  double damped = 0;              ///< energy that damping took [J]
  Ledger ledger;                  ///< of runs by stages
  std::vector<std::string> holders;  ///< pins and moves as they were typed
  std::vector<Reaction> reactions;   ///< of each at the end; empty: not known
  int64_t solves = 0;                ///< minimisations: stages, those of rejected steps included
  int64_t rejected_steps = 0;        ///< that were made again for their time error
  int64_t outside_fit = 0;          ///< voxels outside the box of their nets, summed over the steps
  std::vector<int64_t> long_steps;  ///< steps (from 1) of far more iterations than the median
  StageSeconds stage_seconds;
  std::vector<double> step_ms;  ///< wall time of each step; the file has median and p95
  int64_t peak_memory_bytes = 0;
  std::vector<std::string> notes;  ///< facts worth knowing that are no warnings
  std::vector<std::string> warnings;
  std::string command;  ///< as it was typed
  std::string commit;   ///< of the build
};

/// The value below which the share q of the values lies, with linear interpolation between
/// neighbours; 0 for no values. @param q  0 ... 1.
double quantile(std::vector<double> values, double q);

/// Largest resident memory of this process so far [bytes].
int64_t peak_memory_bytes();

/// Writes the report, under a temporary name first. A number that is not finite becomes null.
/// @throws Error (resources) if the disk refuses it.
void write_report(const std::string& path, const RunReport& report);

}  // namespace elastogen
