// SPDX-License-Identifier: Apache-2.0
// The device beside the CPU on the same steps, with the error of both: whole steps, the iterations
// of a step alone, and the kernels beside the copy bandwidth of the card, all in one run.
//
//   device [VOXELS ...]     prints Markdown tables; 3.2e4 2.56e5 1e6 unless given
//
// beam: clamped, C 10, nu 0.4. c84: E 1e5 Pa, nu 0.4, 1/30 s a step from rest.

#include "bench/scenes.hpp"
#include "network/device_quasi.hpp"
#include "network/solver.hpp"

#include <cuda_runtime_api.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <functional>

namespace elastogen::bench {
namespace {

constexpr int kRepeats = 5, kSteps = 6;

void check(cudaError_t error) {
  if (error != cudaSuccess) throw std::runtime_error(cudaGetErrorString(error));
}

/// Median of some runs, the device at rest before and after each [ms].
double milliseconds(const std::function<void()>& body) {
  std::vector<double> times;
  body();
  for (int k = 0; k < kRepeats; ++k) {
    check(cudaDeviceSynchronize());
    const auto begin = std::chrono::steady_clock::now();
    body();
    check(cudaDeviceSynchronize());
    times.push_back(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin)
            .count());
  }
  std::sort(times.begin(), times.end());
  return times[kRepeats / 2];
}

/// Numbers on the device, uninitialised.
template <class T>
struct Room {
  explicit Room(int64_t size) {
    check(cudaMalloc(reinterpret_cast<void**>(&data), size_t(size) * sizeof(T)));
  }
  ~Room() { cudaFree(data); }
  Room(const Room&) = delete;
  T* data = nullptr;
};

/// Bytes read and written a second by a copy of 2 GB.
double copy_bandwidth() {
  constexpr int64_t kBytes = int64_t(2) << 30;
  Room<char> from(kBytes), to(kBytes);
  const double ms = milliseconds(
      [&] { check(cudaMemcpyAsync(to.data, from.data, kBytes, cudaMemcpyDeviceToDevice)); });
  return 2e3 * double(kBytes) / ms;
}

Scene scene_of(const std::string& name, double voxels) {
  Scene scene = cantilever({.voxels = voxels, .courant = 10, .poisson = 0.4});
  if (name == "beam") return scene;
  scene.dt = 1.0 / 30;
  scene.materials[0].young = 1e5;
  finish_scene(scene);
  return scene;
}

/// A clip's last step on a device.
struct Run {
  State state;
  StepReport report;
  double ms = 0;  ///< median of the steps
};

Run run(const Scene& scene, Device device) {
  SolverOptions options;
  options.mode = SolverMode::kQuasi;
  options.device = device;
  Solver solver(scene, options);
  Run r{initial_state(scene), {}, 0};
  std::vector<double> ms;
  for (int k = 0; k < kSteps; ++k) {
    r.report = solver.step(r.state);
    ms.push_back(r.report.ms);
  }
  std::sort(ms.begin(), ms.end());
  r.ms = ms[kSteps / 2];
  return r;
}

/// Largest distance of two states over the largest motion from rest.
double distance(const Scene& scene, const State& a, const State& b) {
  double largest = 0, motion = 0;
  for (int64_t k = 0; k < a.x.size(); ++k) {
    largest = std::max(largest, std::abs(a.x.data()[k] - b.x.data()[k]));
    motion = std::max(motion, std::abs(b.x.data()[k] - scene.grid.rest.data()[k]));
  }
  return largest / motion;
}

void compare(const std::string& name, double voxels) {
  const Scene scene = scene_of(name, voxels);
  const Run device = run(scene, Device::kCuda), host = run(scene, Device::kCpu);
  // the iterations of the next step alone
  IncrementalPotential potential(scene);
  potential.begin_step(device.state, {TimeScheme::kEuler, scene.dt, 1});
  const Preconditioner<float> first(potential, courant_number(scene) > 2);
  cuda::DeviceQuasi quasi(potential, first);
  quasi.begin_step();
  quasi.set_nodal_rotations(potential.predictor().data());
  const double target = 0.95e-3 * reference_force(scene);
  IterationResult result;
  const auto never = [] { return false; };
  const double solve = milliseconds([&] {
    std::vector<double> u = potential.predictor();
    result = quasi.solve(u.data(), target, 400, device.report.float64, never);
  });
  fmt::print(
      "| {} | {} | {:.0f} | {} | {:.1f} | {:.1f} | {} | {:.1e} | {:.1f} | {} | {:.1e} | {:.1e} |\n",
      name, scene.grid.voxel_count(), courant_number(scene),
      device.report.float64 ? "double" : "float", device.ms, solve, result.inner,
      device.report.residual, host.ms, host.report.inner, host.report.residual,
      distance(scene, device.state, host.state));
  std::fflush(stdout);
}

void kernels(double voxels, double bandwidth) {
  const Scene scene = scene_of("beam", voxels);
  IncrementalPotential potential(scene);
  const State state = initial_state(scene);
  potential.begin_step(state, {TimeScheme::kEuler, scene.dt, 1});
  const Preconditioner<float> first(potential, true), cycle(potential, false);
  cuda::DeviceQuasi quasi(potential, first), without(potential, cycle);
  const auto V = double(scene.grid.voxel_count()), N = double(scene.grid.node_count());
  Room<double> u(int64_t(3 * N)), gradient(int64_t(3 * N));
  Room<float> r(int64_t(3 * N)), z(int64_t(3 * N));
  check(cudaMemset(u.data, 0, size_t(3 * N) * 8));
  check(cudaMemset(r.data, 0, size_t(3 * N) * 4));
  for (cuda::DeviceQuasi* q : {&quasi, &without}) {
    q->begin_step();
    q->set_nodal_rotations(potential.now().data());
  }
  const auto row = [&](const char* name, double bytes, const std::function<void()>& body) {
    const double ms = milliseconds(body);
    fmt::print("| {} | {:.0f} | {:.3f} | {:.0f} | {:.0f} | {:.0f} % |\n", name, V, ms, bytes / V,
               bytes / ms * 1e-6, 100 * bytes / (1e-3 * ms) / bandwidth);
    std::fflush(stdout);
  };
  auto* single = reinterpret_cast<float*>(gradient.data);
  // u, predictor, inertia, gradient; weights and rotations
  row("energy and gradient, float", N * (24 + 24 + 8 + 12) + V * 4 * 14,
      [&] { quasi.potential().evaluate<float>(u.data, single); });
  row("energy and gradient, double", N * (24 + 24 + 8 + 24) + V * 8 * 14,
      [&] { quasi.potential().evaluate<double>(u.data, gradient.data); });
  row("nodal rotations", N * (3 * 24 + 3 * 36) + V * 4,
      [&] { quasi.potential().set_nodal_rotations(u.data); });
  // on the finest level five products (r, z or d, diagonals, 24 B of moduli a voxel), an eighth of
  // all below it
  row("V-cycle, float", 8.0 / 7 * 5 * (N * 60 + V * 24) + N * (72 + 24),
      [&] { without.precondition(r.data, z.data); });
  row("V-cycle and encoder, float",
      8.0 / 7 * 5 * (N * 60 + V * 24) + N * (72 + 24) + N * 2 * (84 + 12),
      [&] { quasi.precondition(r.data, z.data); });
}

}  // namespace
}  // namespace elastogen::bench

int main(int argc, char** argv) {
  try {
    using namespace elastogen::bench;
    std::vector<double> sizes;
    for (int k = 1; k < argc; ++k) sizes.push_back(std::atof(argv[k]));
    if (sizes.empty()) sizes = {3.2e4, 2.56e5, 1e6};
    const double bandwidth = copy_bandwidth();
    fmt::print("{}: copy {:.2f} TB/s, read and written\n\n", elastogen::cuda::device_name(),
               bandwidth * 1e-12);
    fmt::print(
        "| kernel | voxels | ms | B a voxel | GB/s | of the copy |\n|---|---|---|---|---|---|\n");
    for (const double size : sizes) kernels(size, bandwidth);
    fmt::print(
        "\n| scene | voxels | C | numbers | step [ms] | its iterations [ms] | evaluations | "
        "residual | CPU step [ms] | evaluations | residual | distance of both |\n"
        "|---|---|---|---|---|---|---|---|---|---|---|---|\n");
    for (const char* name : {"beam", "c84"})
      for (const double size : sizes) compare(name, size);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "device: {}\n", error.what());
    return 1;
  }
}
