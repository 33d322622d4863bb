// SPDX-License-Identifier: Apache-2.0
#include "bench/bench.hpp"
#include "bench/card.hpp"
#include "bench/lattice.hpp"
#include "bench/timing.hpp"
#include "core/reduce.hpp"
#include "network/precondition/preconditioner.hpp"
#include "network/step/lbfgs.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cstdio>
#include <memory>

namespace elastogen::bench {
namespace {

/// What the kernels of the CPU work on.
struct Bench {
  explicit Bench(const Scene& s)
      : scene(s),
        potential(begun(scene)),
        multigrid(scene, 1),
        encoder(*potential),
        history(3 * scene.grid.node_count()),
        u(3 * size_t(scene.grid.node_count())),
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

  const Scene& scene;
  std::unique_ptr<IncrementalPotential> potential;
  Multigrid<float> multigrid;
  Encoder<float> encoder;
  Lbfgs<double> history;
  std::vector<double> u, g, q, d;
  std::vector<float> p, z;
};

std::vector<KernelRow> host_kernels(const Scene& scene) {
  Bench b(scene);
  const auto N = double(scene.grid.node_count());
  const double slots = double(b.potential->rows().row_count()) * kLanes;
  // weights and rotation of a slot are float64: 5 + 9 numbers; nodes: u, predictor, inertia, result
  const double voxels = slots * 14 * 8;
  std::vector<KernelRow> rows;
  const auto row = [&](const char* name, double bytes, const std::function<void()>& body) {
    rows.push_back({name, bytes, milliseconds(15, body).median});
  };
  row("energy and gradient, float", voxels + N * (24 + 24 + 8 + 12),
      [&] { b.potential->evaluate<float>(b.u.data(), b.p.data()); });
  row("energy and gradient, double", voxels + N * (24 + 24 + 8 + 24),
      [&] { b.potential->evaluate<double>(b.u.data(), b.g.data()); });
  row("projected Hessian", voxels + slots * 45 * 4 + N * 24,
      [&] { b.potential->linearise(b.u.data()); });
  row("Hessian product", voxels + slots * 45 * 4 + N * (12 + 8 + 12),
      [&] { b.potential->hessian_product(b.p.data(), b.z.data()); });
  row("scalar operators, finest level", slots * 24 + N * 36,
      [&] { b.multigrid.operator_product(b.p.data(), b.z.data()); });
  // four products on the finest level and an eighth of that on each coarser one
  row("V-cycle, float", 8.0 / 7 * (4 * (slots * 24 + N * 48) + N * 36),
      [&] { b.multigrid.apply(b.p.data(), b.z.data()); });
  row("encoder, float", 2 * N * (21 * 4 + 12), [&] { b.encoder.add(b.p.data(), b.z.data()); });
  row("L-BFGS recursion, double", N * 24 * (5 * 8 + 3), [&] {
    b.history.direction(b.g.data(), b.q.data(), b.d.data(), [](const double*, double*) {});
  });
  return rows;
}

}  // namespace

Json measure_kernels(const BenchTask& task, const CopyRates& rates) {
  const bool card = resolved(task.device) == Device::kCuda;
  // sizes, and the rate of a copy on the chosen machine
  const double copy = card ? rates.card : rates.host;
  std::vector<double> sizes = task.sizes;
  if (sizes.empty()) sizes = card ? std::vector{3.2e4, 2.56e5, 1e6, 1e7} : std::vector{1e5};
  Json result = Json::array();
  for (const std::string& name : task.scenes)
    for (const double size : sizes) {
      const Scene scene = step_scene(
          name, {.voxels = size, .courant = task.courants[0], .poisson = task.poissons[0]}, 1);
      const auto V = double(scene.grid.voxel_count());
      // time each kernel and compare its rate with that of a copy
      for (const KernelRow& k : card ? card_kernels(scene) : host_kernels(scene)) {
        const double rate = 1e3 * k.bytes / k.ms;
        fmt::print("{} {:.0f}: {:32} {:9.3f} ms {:7.1f} GB/s {:4.0f} % of a copy\n", name, V,
                   k.name, k.ms, 1e-9 * rate, 100 * rate / copy);
        std::fflush(stdout);
        result.push_back({{"scene", name},
                          {"kernel", k.name},
                          {"device", card ? "cuda" : "cpu"},
                          {"voxels", scene.grid.voxel_count()},
                          {"ms", k.ms},
                          {"bytes_a_voxel", k.bytes / V},
                          {"bytes_per_second", rate},
                          {"copy_share", rate / copy}});
      }
    }
  return result;
}

}  // namespace elastogen::bench
