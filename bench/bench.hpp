// SPDX-License-Identifier: Apache-2.0
// The measurements of `elastogen bench`, part by part. Each part gives JSON (docs/formats.md,
// bench); the verb adds the machine, the commit and the copy bandwidth.

#pragma once

#include "network/solver.hpp"

#include <nlohmann/json_fwd.hpp>

#include <string>
#include <vector>

namespace elastogen::bench {

using Json = nlohmann::ordered_json;

struct BenchTask {
  std::vector<std::string> parts;  ///< names from part_names(), in the order of the run
  Device device = Device::kAuto;
  std::vector<double> sizes;                   ///< voxels, or particles; empty: the part's own
  std::vector<double> courants = {10};         ///< (dt/h) sqrt(E/rho)
  std::vector<double> poissons = {0.4};        ///< nu
  std::vector<double> fills = {1};             ///< share of the box that is solid, 0.01 ... 1
  std::vector<std::string> scenes = {"beam"};  ///< beam, ball, c84
  std::vector<SolverMode> solvers = {SolverMode::kQuasi, SolverMode::kNewton, SolverMode::kPaper};
  std::vector<std::string> integrators = {"explicit", "implicit"};  ///< integrators of particles
  std::vector<double> tolerances = {1e-1, 1e-2, 1e-3, 1e-4};        ///< for error-time
  double tolerance = 1e-3;                                          ///< for step and baseline
  bool fem = false;    ///< tip: quadratic tetrahedra, six in each of the voxels of `sizes`
  int repeats = 0;     ///< runs for each time; 0: the part's own
  PaperLoops loops;    ///< of the published algorithm
  std::string python;  ///< program that runs the baseline
  std::string script;  ///< the baseline; empty: the script in the sources
  std::vector<std::string> runs = {"eager-library", "eager-jacobi", "compile-jacobi",
                                   "graph-jacobi"};  ///< mode and SVD of the baseline
};

/// Bytes read and written a second by a copy of arrays larger than any cache; 0 if there is none.
struct CopyRates {
  double host = 0, card = 0;
};

/// The names ceilings, kernels, step, error-time, tip, baseline, particles, startup.
const std::vector<std::string>& part_names();

/// kCuda or kCpu. @throws Error (device) if a device is asked for and there is none.
Device resolved(Device asked);

/// Measures only the copies; those of the card only if the task runs on it.
CopyRates copy_rates(const BenchTask& task);

/// Runs a part by its name and prints its rows as they come.
/// @throws Error (usage) naming the parts for any other name, and what solvers throw.
Json measure(const std::string& part, const BenchTask& task, const CopyRates& rates);

Json measure_ceilings(const BenchTask& task);
/// The kernels of a step: time, bytes that must move at least once, and their share of the copy.
Json measure_kernels(const BenchTask& task, const CopyRates& rates);
/// Steps to the tolerance over sizes, Courant numbers, Poisson ratios and fills.
Json measure_steps(const BenchTask& task, const CopyRates& rates);
/// One step by every solver at every tolerance, with its error.
Json measure_error_time(const BenchTask& task);
/// The tip of c84 in 24 frames, by the network or by quadratic tetrahedra.
Json measure_tip(const BenchTask& task);
/// The published algorithm in PyTorch and the solvers, on one step.
Json measure_baseline(const BenchTask& task);
/// Explicit and implicit steps of sand, on one thread and on more.
Json measure_particles(const BenchTask& task, const CopyRates& rates);
/// Time from the start of the command to its first step, on a mesh of 20448 triangles.
Json measure_startup(const BenchTask& task);

}  // namespace elastogen::bench
