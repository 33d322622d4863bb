// SPDX-License-Identifier: Apache-2.0
// What `elastogen bench` measures, part by part. Each part gives JSON (docs/formats.md, bench); the
// verb puts the machine, the commit and the copy bandwidth beside it.

#pragma once

#include "network/solver.hpp"

#include <nlohmann/json_fwd.hpp>

#include <string>
#include <vector>

namespace elastogen::bench {

using Json = nlohmann::ordered_json;

struct BenchTask {
  std::vector<std::string> parts;  ///< of part_names(), in the order of the run
  Device device = Device::kAuto;
  std::vector<double> sizes;                   ///< voxels, or particles; empty: those of the part
  std::vector<double> courants = {10};         ///< (dt/h) sqrt(E/rho)
  std::vector<double> poissons = {0.4};        ///< nu
  std::vector<double> fills = {1};             ///< share of the box that is solid, 0.01 ... 1
  std::vector<std::string> scenes = {"beam"};  ///< beam, ball, c84
  std::vector<SolverMode> solvers = {SolverMode::kQuasi, SolverMode::kNewton, SolverMode::kPaper};
  std::vector<std::string> integrators = {"explicit", "implicit"};  ///< of particles
  std::vector<double> tolerances = {1e-1, 1e-2, 1e-3, 1e-4};        ///< of error-time
  double tolerance = 1e-3;                                          ///< of step and baseline
  bool fem = false;    ///< tip: quadratic tetrahedra, six in each of the voxels of `sizes`
  int repeats = 0;     ///< of each time; 0: those of the part
  PaperLoops loops;    ///< of the published algorithm
  std::string python;  ///< program that runs the baseline
  std::string script;  ///< of the baseline; empty: that of the sources
  std::vector<std::string> runs = {"eager-library", "eager-jacobi", "compile-jacobi",
                                   "graph-jacobi"};  ///< mode and SVD of the baseline
};

/// Bytes read and written a second by a copy of arrays that no cache holds; 0 where there is none.
struct CopyRates {
  double host = 0, card = 0;
};

/// ceilings, kernels, step, error-time, tip, baseline, particles, startup.
const std::vector<std::string>& part_names();

/// kCuda or kCpu. @throws Error (device) if the device is asked for and there is none.
Device resolved(Device asked);

/// The copies alone, of the card only where the task runs on it.
CopyRates copy_rates(const BenchTask& task);

/// A part by its name, prints its rows as they come.
/// @throws Error (usage) naming the parts for any other name; whatever solvers throw.
Json measure(const std::string& part, const BenchTask& task, const CopyRates& rates);

Json measure_ceilings(const BenchTask& task);
/// The kernels of a step: time, bytes that must move at least once, and their share of the copy.
Json measure_kernels(const BenchTask& task, const CopyRates& rates);
/// Steps to the tolerance over sizes, Courant numbers, Poisson ratios and fills.
Json measure_steps(const BenchTask& task, const CopyRates& rates);
/// One step by every solver at every tolerance, beside its error.
Json measure_error_time(const BenchTask& task);
/// The tip of c84 in 24 frames, by the network or by quadratic tetrahedra.
Json measure_tip(const BenchTask& task);
/// The published algorithm in PyTorch beside the solvers, on the same step.
Json measure_baseline(const BenchTask& task);
/// Explicit and implicit steps of sand, on one thread and on more.
Json measure_particles(const BenchTask& task, const CopyRates& rates);
/// Start of the command to its first step, on a mesh of 20448 triangles.
Json measure_startup(const BenchTask& task);

}  // namespace elastogen::bench
