// SPDX-License-Identifier: Apache-2.0
#include "bench/bench.hpp"
#include "bench/card.hpp"
#include "bench/lattice.hpp"
#include "bench/measure.hpp"
#include "bench/timing.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chrono>
#include <cmath>
#include <cstdio>

namespace elastogen::bench {
namespace {

constexpr int kStepRepeats = 20;

/// Share of the box of a grid that is voxels.
double filled_share(const VoxelGrid& grid) {
  Box box;
  for (int64_t n = 0; n < grid.node_count(); ++n)
    box.add({grid.rest(n, 0), grid.rest(n, 1), grid.rest(n, 2)});
  const double volume = box.extent(0) * box.extent(1) * box.extent(2);
  return double(grid.voxel_count()) * std::pow(grid.h, 3) / volume;
}

int64_t memory_in_use(bool card) {
  return card ? card_memory_used() : resident_bytes();
}

/// What became of one scene.
struct Row {
  std::string scene;
  SceneOptions options;
  double fill = 1, filled_share = 1, courant = 0;
  int64_t voxels = 0;
  std::string device;
  StepReport report;
  Spread ms;
  double setup_seconds = 0;
  int64_t host_bytes = 0, card_bytes = 0;  ///< of scene, state and solver; of the solver
  std::vector<double> drafts;              ///< residuals of the steps before that missed
};

Row run(const BenchTask& task, Row row) {
  const bool card = resolved(task.device) == Device::kCuda;
  const int64_t before = memory_in_use(false), card_before = card ? memory_in_use(true) : 0;
  const Scene scene = step_scene(row.scene, row.options, row.fill);
  row.voxels = scene.grid.voxel_count();
  row.filled_share = filled_share(scene.grid);
  row.courant = courant_number(scene);
  // time the set-up
  const auto begin = std::chrono::steady_clock::now();
  Solver solver(scene, {.mode = SolverMode::kQuasi,
                        .device = card ? Device::kCuda : Device::kCpu,
                        .tolerance = task.tolerance});
  row.setup_seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  row.device = solver.device();
  // time the step after the first ones, always from one state
  State start = initial_state(scene);
  for (int k = 0; k < kStepsBefore; ++k) {
    const StepReport report = solver.step(start);
    if (!report.converged) row.drafts.push_back(report.residual);
  }
  std::vector<double> ms;
  const int repeats = task.repeats > 0 ? task.repeats : kStepRepeats;
  for (int k = 0; k <= repeats; ++k) {
    solver.begin(start);
    row.report = solver.advance();
    if (k > 0) ms.push_back(row.report.ms);  // the first one warms up
  }
  row.ms = spread_of(ms);
  row.host_bytes = memory_in_use(false) - before;
  if (card) row.card_bytes = memory_in_use(true) - card_before;
  return row;
}

Json json(const Row& row, double copy) {
  const auto V = double(row.voxels);
  const StepReport& r = row.report;
  // copied_bytes_a_voxel: bytes that a copy moves in the median time
  return {{"scene", row.scene},
          {"voxels", row.voxels},
          {"courant", row.courant},
          {"poisson", row.options.poisson},
          {"fill", row.fill},
          {"filled_share", row.filled_share},
          {"solver", "quasi"},
          {"device", row.device},
          {"ms", row.ms.median},
          {"ms_lower_quartile", row.ms.lower},
          {"ms_upper_quartile", row.ms.upper},
          {"copied_bytes_a_voxel", 1e-3 * row.ms.median * copy / V},
          {"residual", r.residual},
          {"converged", r.converged},
          {"residuals_of_drafts_before", row.drafts},
          {"outer", r.outer},
          {"evaluations", r.inner},
          {"float64", r.float64},
          {"setup_seconds", row.setup_seconds},
          {"host_bytes_a_voxel", double(row.host_bytes) / V},
          {"card_bytes_a_voxel",
           row.card_bytes > 0 ? Json(double(row.card_bytes) / V) : Json(nullptr)}};
}

void print(const Row& row) {
  const StepReport& r = row.report;
  fmt::print(
      "{} {} voxels, C {:.0f}, nu {}, fill {}, {}: {:.2f} ms ({:.2f} ... {:.2f}), residual "
      "{:.1e}{}, {} evaluations in {}\n",
      row.scene, row.voxels, row.courant, row.options.poisson, row.fill, row.device, row.ms.median,
      row.ms.lower, row.ms.upper, r.residual, r.converged ? "" : " (draft)", r.inner,
      r.float64 ? "double" : "float");
  std::fflush(stdout);
}

}  // namespace

Json measure_steps(const BenchTask& task, const CopyRates& rates) {
  const bool card = resolved(task.device) == Device::kCuda;
  std::vector<double> sizes = task.sizes;
  if (sizes.empty()) sizes = card ? std::vector{3.2e4, 1e5, 2.56e5, 1e6, 1e7} : std::vector{1e5};
  Json result = Json::array();
  for (const std::string& name : task.scenes) {
    // C, nu and fill of c84 are its own, and only the beam has a fill
    const bool own = name == "c84", beam = name == "beam";
    for (const double size : sizes)
      for (const double courant : own ? std::vector{10.0} : task.courants)
        for (const double poisson : own ? std::vector{0.4} : task.poissons)
          for (const double fill : beam ? task.fills : std::vector{1.0}) {
            Row row;
            row.scene = name, row.fill = fill;
            row.options = {.voxels = size, .courant = courant, .poisson = poisson};
            row = run(task, row);
            print(row);
            result.push_back(json(row, card ? rates.card : rates.host));
          }
  }
  return result;
}

}  // namespace elastogen::bench
