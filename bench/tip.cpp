// SPDX-License-Identifier: Apache-2.0
// The tip of c84 frame by frame, by the network and by quadratic finite elements: the middle of the
// free end falls as the cantilever bends under its weight. Steps are implicit Euler of a frame in
// both, so that what differs is the space.
#include "bench/bench.hpp"
#include "bench/lattice.hpp"
#include "bench/timing.hpp"
#include "mpm_fem/fem/voxel_tets.hpp"
#include "mpm_fem/integrators/implicit_fem.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace elastogen::bench {
namespace {

constexpr int kFrames = 24;  // 0.8 s: then the surface folds at the clamp
constexpr double kFemTolerance = 1e-6;

/// The nodes nearest to the middle of the free end: one, or the four around it.
std::vector<int64_t> tip_nodes(const Array<double>& rest) {
  const auto away = [&](int64_t n) {
    return std::hypot(rest(n, 0) - 1, rest(n, 1) - 0.125, rest(n, 2) - 0.125);
  };
  double least = 1e300;
  for (int64_t n = 0; n < rest.rows(); ++n) least = std::min(least, away(n));
  std::vector<int64_t> nodes;
  for (int64_t n = 0; n < rest.rows(); ++n)
    if (away(n) < least + 1e-9) nodes.push_back(n);
  return nodes;
}

/// Mean height of some nodes above their place at rest [m].
double height(const std::vector<int64_t>& nodes, const Array<double>& x,
              const Array<double>& rest) {
  double sum = 0;
  for (const int64_t n : nodes) sum += x(n, 1) - rest(n, 1);
  return sum / double(nodes.size());
}

/// A clip that is stepped frame by frame.
struct Curve {
  Curve(std::string name, std::string where) : run(std::move(name)), device(std::move(where)) {}

  std::string run, device;
  int64_t voxels = 0, unknowns = 0;
  std::vector<double> tip, ms;
  double residual = 0;  ///< the largest
  int converged = 0;

  void add(const StepReport& report, double height) {
    tip.push_back(height);
    ms.push_back(report.ms);
    residual = std::max(residual, report.residual);
    converged += report.converged;
  }
};

Curve by_network(const BenchTask& task, const Scene& scene) {
  Solver solver(scene, {.device = resolved(task.device), .tolerance = task.tolerance});
  const std::vector<int64_t> tip = tip_nodes(scene.grid.rest);
  Curve curve("auto", solver.device());
  State state = initial_state(scene);
  solver.begin(state);
  for (int frame = 0; frame < kFrames; ++frame) {
    const StepReport report = solver.advance();
    solver.read(state, StateParts::kPositions);
    curve.add(report, height(tip, state.x, scene.grid.rest));
  }
  curve.unknowns = 3 * scene.grid.node_count();
  return curve;
}

Curve by_fem(const Scene& scene) {
  fem::FemScene fem;
  fem.mesh = fem::quadratic(fem::voxel_tets(scene, fem::VoxelSplit::kSix));
  fem.materials = scene.materials;
  fem.gravity = scene.gravity;
  fem.dt = scene.dt;
  fem.mass_kind = fem::Mass::kConsistent;
  const Array<double>& rest = fem.mesh.rest;
  fem.fixed = Array<uint8_t>(rest.rows(), 3);
  for (int64_t n = 0; n < rest.rows(); ++n)
    if (rest(n, 0) < 1e-9) std::fill_n(fem.fixed.row(n), 3, uint8_t(1));
  fem::ImplicitFem solver(fem, {.tolerance = kFemTolerance});
  const std::vector<int64_t> tip = tip_nodes(rest);
  Curve curve("tet10", "cpu");
  fem::FemState state = fem::rest_state(fem);
  for (int frame = 0; frame < kFrames; ++frame) {
    const fem::FemStepReport report = solver.step(state);
    Array<double> x = state.u;
    for (int64_t k = 0; k < x.size(); ++k) x.data()[k] += rest.data()[k];
    curve.add(report, height(tip, x, rest));
  }
  curve.unknowns = 3 * rest.rows();
  return curve;
}

Json json(const Curve& c) {
  fmt::print(
      "{} {} voxels, {}: {:.2f} ms a frame, {} of {} converged, worst residual {:.1e}, tip {:.5f} "
      "m\n",
      c.run, c.voxels, c.device, spread_of(c.ms).median, c.converged, kFrames, c.residual,
      c.tip.back());
  std::fflush(stdout);
  return {{"scene", "c84"},         {"run", c.run},
          {"device", c.device},     {"voxels", c.voxels},
          {"unknowns", c.unknowns}, {"ms", spread_of(c.ms).median},
          {"residual", c.residual}, {"converged", c.converged},
          {"frames", kFrames},      {"tip", c.tip}};
}

}  // namespace

Json measure_tip(const BenchTask& task) {
  std::vector<double> sizes = task.sizes;
  if (sizes.empty())
    sizes = task.fem ? std::vector{256.0, 2048.0} : std::vector{3.2e4, 2.56e5, 1e6};
  Json rows = Json::array();
  for (const double size : sizes) {
    const Scene scene = step_scene("c84", {.voxels = size, .poisson = 0.4}, 1);
    Curve curve = task.fem ? by_fem(scene) : by_network(task, scene);
    curve.voxels = scene.grid.voxel_count();
    rows.push_back(json(curve));
  }
  return rows;
}

}  // namespace elastogen::bench
