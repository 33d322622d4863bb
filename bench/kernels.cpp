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
#include <memory>

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

/// What the kernels work on.
struct Bench {
  explicit Bench(double wanted)
      : scene(porous_ball({.voxels = wanted, .poisson = 0.4})),
        V(double(scene.grid.voxel_count())),
        N(double(scene.grid.node_count())),
        potential(begun(scene)),
        multigrid(scene, 1),
        encoder(*potential),
        history(int64_t(3 * N)),
        u(size_t(3 * N)),
        g(u.size()),
        q(u.size()),
        d(u.size()),
        p(u.size()),
        z(u.size()) {
    for (size_t k = 0; k < u.size(); ++k) u[k] = 1e-4 * double(k % 7), p[k] = float(k % 5);
    for (int k = 0; k < Lbfgs<double>::kPairs; ++k) {
      std::copy(u.begin(), u.end(), history.next_s());
      std::copy(u.begin(), u.end(), history.next_y());
      history.keep();
    }
    potential->linearise(u.data());
  }

  static std::unique_ptr<IncrementalPotential> begun(const Scene& scene) {
    auto result = std::make_unique<IncrementalPotential>(scene);
    const State state = initial_state(scene);
    result->begin_step(state, step_scheme(scene, state));
    return result;
  }

  void line(const char* name, double bytes, const std::function<void()>& body) const {
    const double t = seconds(body);
    fmt::print("| {} | {:.2f} | {:.1f} | {:.0f} | {:.1f} | {:.0f} % |\n", name, 1e3 * t,
               1e9 * t / V, bytes / V, bytes / t / 1e9, 100 * bytes / t / copy);
  }

  Scene scene;
  double V, N, copy = copy_bandwidth();
  std::unique_ptr<IncrementalPotential> potential;
  Multigrid<float> multigrid;
  Encoder<float> encoder;
  Lbfgs<double> history;
  std::vector<double> u, g, q, d;
  std::vector<float> p, z;
};

void run(double wanted) {
  Bench b(wanted);
  const double V = b.V, N = b.N, slots = double(b.potential->rows().row_count()) * kLanes;
  fmt::print("{} voxels, {} nodes, lanes in use {:.0f} %, copy {:.1f} GB/s\n\n", V, N,
             100 * V / slots, b.copy / 1e9);
  fmt::print(
      "| kernel | ms | ns a voxel | B a voxel | GB/s | share of copy |\n"
      "|---|---|---|---|---|---|\n");
  // weights and rotation of a slot are float64: 5 + 9 numbers; nodes: u, predictor, inertia, result
  const double voxel_data = slots * 14 * 8;
  b.line("energy and gradient, float", voxel_data + N * (24 + 24 + 8 + 12),
         [&] { b.potential->evaluate<float>(b.u.data(), b.p.data()); });
  b.line("energy and gradient, float64", voxel_data + N * (24 + 24 + 8 + 24),
         [&] { b.potential->evaluate<double>(b.u.data(), b.g.data()); });
  b.line("projected Hessian", voxel_data + slots * 45 * 4 + N * 24,
         [&] { b.potential->linearise(b.u.data()); });
  b.line("Hessian product", voxel_data + slots * 45 * 4 + N * (12 + 8 + 12),
         [&] { b.potential->hessian_product(b.p.data(), b.z.data()); });
  b.line("scalar operators, finest level", slots * 24 + N * 36,
         [&] { b.multigrid.operator_product(b.p.data(), b.z.data()); });
  // four products on the finest level and an eighth of that on each coarser one
  b.line("V-cycle", 8.0 / 7 * (4 * (slots * 24 + N * 48) + N * 36),
         [&] { b.multigrid.apply(b.p.data(), b.z.data()); });
  b.line("encoder", 2 * N * (21 * 4 + 12), [&] { b.encoder.add(b.p.data(), b.z.data()); });
  b.line("L-BFGS recursion, float64", N * 24 * (5 * 8 + 3), [&] {
    b.history.direction(b.g.data(), b.q.data(), b.d.data(), [](const double*, double*) {});
  });
}

}  // namespace
}  // namespace elastogen::bench

int main(int argc, char** argv) {
  elastogen::bench::run(argc > 1 ? std::atof(argv[1]) : 1e5);
}
