// SPDX-License-Identifier: Apache-2.0
// The cost of a net in place of a law: stress and projected Hessian of a voxel from its deformation
// gradient, by the law, by the table and by the net; and whole steps.
//
//   laws [WEIGHTS LAW POISSON]   prints Markdown tables; without arguments the net with weights 0

#include "bench/scenes.hpp"
#include "core/parallel.hpp"
#include "core/principal.hpp"
#include "network/law/mtl_weights.hpp"
#include "network/solver.hpp"

#include <Eigen/Dense>
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <random>
#include <sstream>

namespace elastogen::bench {
namespace {

using Clock = std::chrono::steady_clock;
using Rows = std::vector<Mat3<Pack<float>>>;

/// Shortest of several runs [s].
double seconds(int runs, const std::function<void()>& body) {
  double best = 1e300;
  for (int k = 0; k < runs; ++k) {
    const auto start = Clock::now();
    body();
    benchmark::ClobberMemory();
    best = std::min(best, std::chrono::duration<double>(Clock::now() - start).count());
  }
  return best;
}

/// Random deformation gradients within about 30 % of the identity.
Rows gradients(int64_t rows) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<float> uniform(-0.15f, 0.15f);
  Rows F(static_cast<size_t>(rows));
  for (auto& row : F)
    for (int k = 0; k < 9; ++k)
      for (int l = 0; l < kLanes; ++l) row.m[k][l] = float(k % 4 == 0) + uniform(random);
  return F;
}

/// Time per voxel [ns] for Newton's quantities: P and the projected Hessian.
double voxel_time(const Rows& F, const LearnedLaw* net, const LawParameters<float>& law, int runs) {
  std::vector<float> sums(F.size());
  const auto pass = [&] {
    for_each(int64_t(F.size()), [&](int64_t r) {
      Pack<float> outside;
      const Svd3<Pack<float>> s = svd3(F[size_t(r)]);
      const auto response = material_response<true>(net, law, s.sigma, outside);
      const Mat3<Pack<float>> P = first_piola(s, response.t);
      const auto H = positive_part(principal_hessian(s.sigma, response));
      const Pack<float> sum = P.m[0] + H.A.m[0] + H.twist[0] + H.flip[1];
      sums[size_t(r)] = sum[0];
    });
    benchmark::DoNotOptimize(sums.data());
  };
  return 1e9 * seconds(runs, pass) / double(F.size() * kLanes);
}

/// Time for a voxel [ns] of the response alone, from stretches, without SVD and projection.
double response_time(const Rows& F, const LearnedLaw* net, const LawParameters<float>& law,
                     int runs) {
  std::vector<float> sums(F.size());
  const auto pass = [&] {
    for_each(int64_t(F.size()), [&](int64_t r) {
      Pack<float> outside;
      const Pack<float> s[3] = {F[size_t(r)].m[0], F[size_t(r)].m[4], F[size_t(r)].m[8]};
      const auto response = material_response<true>(net, law, s, outside);
      sums[size_t(r)] = response.t[0][0] + response.H[5][1];
    });
    benchmark::DoNotOptimize(sums.data());
  };
  return 1e9 * seconds(runs, pass) / double(F.size() * kLanes);
}

/// FLOP/s of products of large matrices, on as many threads as loops use.
double product_rate() {
  constexpr int kSize = 768;
  const Eigen::MatrixXd A = Eigen::MatrixXd::Random(kSize, kSize);
  constexpr int64_t kProducts = 8;
  std::vector<Eigen::MatrixXd> C(kProducts, A);
  const double t =
      seconds(5, [&] { for_each(kProducts, [&](int64_t k) { C[size_t(k)].noalias() = A * A; }); });
  return 2.0 * kSize * kSize * kSize * kProducts / t;
}

struct Nets {
  std::shared_ptr<const LearnedLaw> table, net;
};

Nets read_nets(int argc, char** argv) {
  if (argc < 4) {
    const std::vector<float> zero(size_t(NeuralMtl::kParameters), 0.0f);
    const auto make = [&](Evaluation e) {
      return std::make_shared<LearnedLaw>(zero, Law::kNeoHookean, 0.4, "none", e);
    };
    return {make(Evaluation::kTable), make(Evaluation::kNet)};
  }
  std::ostringstream bytes;
  bytes << std::ifstream(argv[1], std::ios::binary).rdbuf();
  const Law law = law_from_name(argv[2]);
  const double poisson = std::atof(argv[3]);
  return {read_weights(bytes.str(), argv[1], law, poisson, Evaluation::kTable),
          read_weights(bytes.str(), argv[1], law, poisson, Evaluation::kNet)};
}

void print_voxels(const Nets& nets) {
  Material m;
  m.law = nets.table->law(), m.poisson = nets.table->poisson();
  const LawParameters<float> law{m.law, float(m.mu()), float(m.lambda())};
  const Rows many = gradients(1 << 15), few = gradients(1 << 9);
  const double analytic = voxel_time(many, nullptr, law, 9);
  // multiplications and additions of the second layer on ten channels for three axes
  const double flop = 3 * 10 * 2.0 * NeuralMtl::kWidth * NeuralMtl::kWidth;
  const double peak = product_rate(), net = voxel_time(few, nets.net.get(), law, 5);
  const double table = voxel_time(many, nets.table.get(), law, 9);
  fmt::print("| | ns a voxel | over the law's | response alone [ns] |\n|---|---|---|---|\n");
  fmt::print("| law | {:.1f} | 1 | {:.1f} |\n", analytic, response_time(many, nullptr, law, 9));
  fmt::print("| table ({} kB) | {:.1f} | {:.2f} | {:.1f} |\n", nets.table->table().bytes() / 1000,
             table, table / analytic, response_time(many, nets.table.get(), law, 9));
  fmt::print("| net | {:.0f} | {:.0f} | {:.0f} |\n\n", net, net / analytic,
             response_time(few, nets.net.get(), law, 5));
  fmt::print("The net: {:.2f} MFLOP a voxel, {:.1f} GFLOP/s, {:.0f} % of {:.1f} GFLOP/s.\n",
             flop / 1e6, flop / net, 100 * flop / net * 1e9 / peak, peak / 1e9);
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// A run, with the times and iterations of its steps.
struct Run {
  Run(const Scene& scene, const LearnedLaws& learned, SolverMode mode)
      : solver(scene, {.mode = mode, .learned = learned}), state(initial_state(scene)) {}

  void step() {
    const StepReport report = solver.step(state);
    ms.push_back(report.ms);
    outer += report.outer;
  }

  Solver solver;
  State state;
  std::vector<double> ms;
  int64_t outer = 0;
};

/// Steps with law and table alternate; the ratio is the median of the ratios of the steps.
void print_steps(const Nets& nets) {
  constexpr int kSteps = 25;
  Scene scene = porous_ball({.voxels = 3e4, .poisson = nets.table->poisson()});
  scene.materials[0].law = nets.table->law();
  fmt::print("\n| solver, {} voxels | law [ms] | table [ms] | ratio | iterations a step |\n",
             scene.grid.voxel_count());
  fmt::print("|---|---|---|---|---|\n");
  for (const SolverMode mode : {SolverMode::kQuasi, SolverMode::kNewton}) {
    Run law(scene, {}, mode), table(scene, {nets.table}, mode);
    std::vector<double> ratio;
    for (int k = 0; k < kSteps; ++k) {
      law.step(), table.step();
      ratio.push_back(table.ms.back() / law.ms.back());
    }
    fmt::print("| {} | {:.0f} | {:.0f} | {:.2f} | {:.1f}, {:.1f} |\n", solver_name(mode),
               median(law.ms), median(table.ms), median(ratio), double(law.outer) / kSteps,
               double(table.outer) / kSteps);
  }
}

void print_setup(const Nets& nets) {
  const double t = seconds(3, [&] {
    const LearnedLaw anew(nets.table->weights(), nets.table->law(), nets.table->poisson(), "");
    benchmark::DoNotOptimize(&anew);
  });
  fmt::print("\nMaking the table: {:.0f} ms.\n", 1e3 * t);
}

}  // namespace
}  // namespace elastogen::bench

int main(int argc, char** argv) {
  using namespace elastogen::bench;
  const Nets nets = read_nets(argc, argv);
  print_voxels(nets);
  print_setup(nets);
  print_steps(nets);
}
