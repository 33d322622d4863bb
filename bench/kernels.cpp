// SPDX-License-Identifier: Apache-2.0
// The hot kernels of a step: time, bytes that must move at least once, and their share of the copy
// bandwidth measured in the same run.
//
//   kernels [VOXELS]     prints a Markdown table

#include "bench/scenes.hpp"
#include "core/reduce.hpp"
#include "network/lbfgs.hpp"
#include "network/preconditioner.hpp"

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <chrono>
#include <cstdlib>
#include <functional>

namespace elastogen::bench {
namespace {

/// Shortest of 15 runs [s].
double seconds(const std::function<void()>& body) {
  double best = 1e300;
  for (int k = 0; k < 15; ++k) {
    const auto start = std::chrono::steady_clock::now();
    body();
    benchmark::ClobberMemory();
    best = std::min(
        best, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return best;
}

/// Bytes read and written a second by a parallel copy of arrays far larger than the caches.
double copy_bandwidth() {
  constexpr int64_t kSize = 64 << 20;
  std::vector<float> from(kSize, 1), to(kSize);
  const double t = seconds([&] {
    for_blocks(
        kSize,
        [&](int64_t b, int64_t e) {
          std::copy(from.begin() + b, from.begin() + e, to.begin() + b);
        },
        1 << 18);
  });
  return 2 * kSize * sizeof(float) / t;
}

void run(double wanted) {
  const Scene scene = porous_ball({.voxels = wanted, .poisson = 0.4});
  const double V = double(scene.grid.voxel_count()), N = double(scene.grid.node_count());
  IncrementalPotential potential(scene);
  State state = initial_state(scene);
  potential.begin_step(state, step_scheme(scene, state));
  Preconditioner<float> preconditioner(potential, true);
  Multigrid<float> multigrid(scene, 1);
  Encoder<float> encoder(potential);
  Lbfgs<double> history(int64_t(3 * N));
  std::vector<double> u(size_t(3 * N)), g(u.size()), q(u.size()), d(u.size());
  std::vector<float> p(u.size()), z(u.size());
  for (size_t k = 0; k < u.size(); ++k) u[k] = 1e-4 * double(k % 7), p[k] = float(k % 5);
  for (int k = 0; k < Lbfgs<double>::kPairs; ++k) {
    std::copy(u.begin(), u.end(), history.next_s());
    std::copy(u.begin(), u.end(), history.next_y());
    history.keep();
  }
  potential.linearise(u.data());

  const double copy = copy_bandwidth();
  const double slots = double(potential.rows().row_count()) * kLanes;
  fmt::print("{} voxels, {} nodes, lanes in use {:.0f} %, copy {:.1f} GB/s\n\n", V, N,
             100 * V / slots, copy / 1e9);
  fmt::print(
      "| kernel | ms | ns a voxel | B a voxel | GB/s | share of copy "
      "|\n|---|---|---|---|---|---|\n");
  const auto line = [&](const char* name, double bytes, const std::function<void()>& body) {
    const double t = seconds(body);
    fmt::print("| {} | {:.2f} | {:.1f} | {:.0f} | {:.1f} | {:.0f} % |\n", name, 1e3 * t,
               1e9 * t / V, bytes / V, bytes / t / 1e9, 100 * bytes / t / copy);
  };
  // weights and rotation of a slot are float64: 5 + 9 numbers; nodes: u, predictor, inertia, result
  const double voxel_data = slots * 14 * 8;
  line("energy and gradient, float", voxel_data + N * (24 + 24 + 8 + 12),
       [&] { potential.evaluate<float>(u.data(), p.data()); });
  line("energy and gradient, float64", voxel_data + N * (24 + 24 + 8 + 24),
       [&] { potential.evaluate<double>(u.data(), g.data()); });
  line("projected Hessian", voxel_data + slots * 45 * 4 + N * 24,
       [&] { potential.linearise(u.data()); });
  line("Hessian product", voxel_data + slots * 45 * 4 + N * (12 + 8 + 12),
       [&] { potential.hessian_product(p.data(), z.data()); });
  line("scalar operators, finest level", slots * 24 + N * 36,
       [&] { multigrid.operator_product(p.data(), z.data()); });
  // four products on the finest level and an eighth of that on each coarser one
  line("V-cycle", 8.0 / 7 * (4 * (slots * 24 + N * 48) + N * 36),
       [&] { multigrid.apply(p.data(), z.data()); });
  line("encoder", 2 * N * (21 * 4 + 12), [&] { encoder.add(p.data(), z.data()); });
  line("L-BFGS recursion, float64", N * 24 * (5 * 8 + 3),
       [&] { history.direction(g.data(), q.data(), d.data(), [](const double*, double*) {}); });
}

}  // namespace
}  // namespace elastogen::bench

int main(int argc, char** argv) {
  elastogen::bench::run(argc > 1 ? std::atof(argv[1]) : 1e5);
}
